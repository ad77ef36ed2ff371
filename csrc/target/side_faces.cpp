#include "target/side_faces.hpp"

namespace rvdnav {

bool side_separation(const rvdnav_edge_model& model, const ViewPose& view, int32_t edge, const double* normal,
                     double* separation) {
  const double *from = edge_end(model, edge, 0), *to = edge_end(model, edge, 1);
  double middle[3], front[3], back[3], outward[3];
  for (int32_t i = 0; i < 3; ++i) middle[i] = 0.5 * (from[i] + to[i]);
  view.place(middle, front);
  middle[0] += model.thickness;
  view.place(middle, back);
  if (!(front[2] > 0.0 && back[2] > 0.0)) return false;
  math::multiply_3(view.R, model.side_normals + 3 * edge, outward);
  const bool in_sight = outward[0] * front[0] + outward[1] * front[1] + outward[2] * front[2] < 0.0;
  *separation = 0.0;
  for (int32_t i = 0; in_sight && i < 2; ++i) {
    *separation += normal[i] * view.focal * (back[i] / back[2] - front[i] / front[2]);
  }
  return true;
}

}  // namespace rvdnav
