// The Delassus operator's storage: entries keep their place while room is made for more contacts.
#include "contact/delassus.h"

#include "check.h"

namespace {

// Any number that no other entry has.
double entry(int i, int j) { return 1000.0 * i + j + 0.5; }

void entries_stay_while_contacts_join(int most) {
  hp::Delassus A;
  for (int n = 0; n < most; n++) {
    A.reserve(n + 1, n);
    CHECK(A.stride() >= 3 * (size_t)(n + 1));
    for (int j = 0; j <= n; j++)
      for (int p = 0; p < 3; p++)
        for (int q = 0; q < 3; q++) {
          A.block(n, j)[p * A.stride() + q] = entry(3 * n + p, 3 * j + q);
          A.block(j, n)[q * A.stride() + p] = entry(3 * j + q, 3 * n + p);
        }
  }
  for (int i = 0; i < 3 * most; i++)
    for (int j = 0; j < 3 * most; j++) CHECK(A.row(i)[j] == entry(i, j));
}

void cleared_it_grows_anew() {
  hp::Delassus A;
  A.reserve(100, 0);
  A.clear();
  A.reserve(1, 0);
  CHECK(A.stride() < 3 * 100);
}

}  // namespace

int main() {
  for (int n : {1, 2, 17, 60}) entries_stay_while_contacts_join(n);
  cleared_it_grows_anew();
  return check::report("test_delassus");
}
