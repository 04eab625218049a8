#include "assembly/skin_shapes.h"

namespace hp::assembly {

namespace {

std::shared_ptr<const Skin> make_skin(Ints body, Ints dof, Ints parent, Rows3 joint, Rows3 rest,
                                      Ints first, Ints at, Doubles weight, Cube bend) {
  auto skin = std::make_shared<Skin>();
  skin->body = list<int>(body), skin->dof = list<int>(dof), skin->parent = list<int>(parent);
  skin->joint = vectors(joint), skin->rest = vectors(rest);
  skin->first_weight = list<int>(first), skin->weight_joint = list<int>(at);
  skin->weight = list<double>(weight);
  const size_t n = rest.shape(0), joints = joint.shape(0);
  need(body.shape(0) == joints && dof.shape(0) == joints && parent.shape(0) == joints &&
           first.shape(0) == n + 1 && at.shape(0) == weight.shape(0) &&
           (size_t)skin->first_weight[n] == at.shape(0),
       "SkinShapes: arrays that do not fit together");
  need(skin->first_weight[0] == 0, "SkinShapes: weights are out of order");
  for (size_t v = 0; v < n; v++)
    need(skin->first_weight[v] < skin->first_weight[v + 1], "SkinShapes: a vertex without weights");
  for (size_t v = 0; v < n; v++) {
    double sum = 0;
    for (int k = skin->first_weight[v]; k < skin->first_weight[v + 1]; k++) sum += skin->weight[k];
    need(sum > 0, "SkinShapes: a vertex whose weights are 0");
  }
  for (size_t j = 0; j < joints; j++)
    need(skin->parent[j] >= -1 && skin->parent[j] < (int)j && (j == 0 || skin->parent[j] >= 0),
         "SkinShapes: parents must precede their children");
  for (int j : skin->weight_joint) need(j >= 0 && (size_t)j < joints, "SkinShapes: no such joint");
  need(bend.shape(0) == 0 ||
           (bend.shape(0) == n && bend.shape(1) == 3 && bend.shape(2) == (size_t)skin->features()),
       "SkinShapes: bend has the wrong shape");
  skin->pose_blend.assign(bend.data(), bend.data() + bend.size());
  return skin;
}

std::vector<CollisionShape> make_hulls(const std::shared_ptr<const Skin>& skin, Ints part,
                                       Ints start, Ints vertex) {
  const int count = (int)vertex.shape(0);
  need(start.shape(0) == part.shape(0) + 1, "SkinShapes: one part per hull");
  std::vector<CollisionShape> shapes;
  for (size_t h = 0; h < part.shape(0); h++) {
    const int begin = start.data()[h], end = start.data()[h + 1];
    need(0 <= begin && begin < end && end <= count, "SkinShapes: a hull needs a vertex");
    CollisionShape v;
    v.skin = skin, v.part = part.data()[h];
    v.vertex.assign(vertex.data() + begin, vertex.data() + end);
    for (int i : v.vertex)
      need(i >= 0 && (size_t)i < skin->rest.size(), "SkinShapes: no such vertex");
    v.finish();
    shapes.push_back(std::move(v));
  }
  return shapes;
}

}  // namespace

SkinShapes skin_shapes(Ints body, Ints dof, Ints parent, Rows3 joint, Rows3 rest, Ints first,
                       Ints at, Doubles weight, Cube bend, Ints part, Ints start, Ints vertex) {
  auto skin = make_skin(body, dof, parent, joint, rest, first, at, weight, bend);
  auto shapes = make_hulls(skin, part, start, vertex);
  return {std::move(skin), std::move(shapes)};
}

}  // namespace hp::assembly
