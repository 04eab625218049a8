// Elementary functions with the same bits everywhere: sines, exponentials and their inverses from additions,
// multiplications, divisions and square roots alone, which IEEE 754 fixes to the last bit. Those of the C libraries differ
// by machine (with and without fused multiply-add), by system and in browsers, and contact makes millimetres of a last bit.
//
// Errors are under 1 unit in the last place (atan 1.2; tan, asin, acos, pow 3), measured against long double in
// tests/native/math/test_elementary.cpp. Sines lose digits beyond 1e5 rad. Special values are those of the C library.
#pragma once

namespace hp::elementary {

void sin_cos(double x, double& sine, double& cosine);
double sin(double x);
double cos(double x);
double tan(double x);
double atan(double x);
double atan2(double y, double x);
double asin(double x);
double acos(double x);
double exp(double x);
double log(double x);
double pow(double base, double exponent);  // base >= 0
// Length of (x, y), both under 1e150.
double hypot(double x, double y);

}  // namespace hp::elementary
