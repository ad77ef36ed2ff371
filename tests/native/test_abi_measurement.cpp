// The measurement over the C ABI: a pose that is known, refusals, and numbers of any size.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "lent.hpp"
#include "measuring.hpp"

namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr scene::Placement kPlacement = {0.7, 0.02, 0.05, -0.1};

// One drawn stereo frame; a context of no target, for the measurement brings its own.
struct Frame {
  std::vector<uint8_t> pixels[2] = {scene::draw(0, kPlacement), scene::draw(1, kPlacement)};
  rvdnav_image left = scene::image(pixels[0]), right = scene::image(pixels[1]);
  scene::Owner owner = scene::Owner(scene::config(), scene::rig(), nullptr);

  rvdnav_status measure(scene::Measuring& measuring) const { return measure(measuring, &left, &right); }
  rvdnav_status measure(scene::Measuring& measuring, const rvdnav_image* first, const rvdnav_image* second) const {
    size_t size = 0;
    uint32_t parameters = 0;
    const rvdnav_status status = rvdnav_measure_size(owner.context, &measuring.problem, &size, &parameters);
    if (status != RVDNAV_OK) return status;
    if (parameters > scene::kParameters) return RVDNAV_ERROR_CAPACITY;  // more than Measuring has room for
    const Lent memory(size);
    const rvdnav_status measured =
        rvdnav_measure(owner.context, first, second, &measuring.problem, memory.data(), size, &measuring.result);
    CHECK(memory.intact());
    return measured;
  }
};

const Frame& frame() {
  static const Frame drawn;
  return drawn;
}

double distance(const double* p) {
  const double at[3] = {kPlacement.range, kPlacement.y, kPlacement.z};
  double square = 0.0;
  for (int i = 0; i < 3; ++i) square += (p[i] - at[i]) * (p[i] - at[i]);
  return std::sqrt(square);
}

}  // namespace

TEST_CASE("a drawn bracket is measured where it stands") {
  scene::Measuring both(kPlacement);
  REQUIRE(frame().measure(both) == RVDNAV_OK);
  // Four samples a pixel put an upright edge up to a quarter of one off.
  CHECK(distance(both.result.pose.p_W) < 1e-3);
  CHECK(both.result.settled == 1);
  CHECK(both.result.line_count == scene::kImages);
  for (const rvdnav_edge_evidence& edge : both.evidence) {
    CHECK(edge.agreed > 0.9 * edge.attempted);
    CHECK(edge.polarity != 0);
  }
  // The same again, bit for bit; one view alone knows less.
  scene::Measuring again(kPlacement), one(kPlacement);
  REQUIRE(frame().measure(again) == RVDNAV_OK);
  for (int i = 0; i < 36; ++i) CHECK(again.result.pose.covariance[i] == both.result.pose.covariance[i]);
  REQUIRE(frame().measure(one, nullptr, &frame().right) == RVDNAV_OK);
  CHECK(one.result.line_count == RVDNAV_EDGES);
  CHECK(distance(one.result.pose.p_W) < 2e-3);
  CHECK(one.result.pose.covariance[0] > both.result.pose.covariance[0]);
}

TEST_CASE("a measurement out of its range is refused") {
  using scene::Measuring;
  const auto refused = [](auto change) {
    Measuring measuring(kPlacement);
    change(measuring);
    return frame().measure(measuring);
  };
  CHECK(refused([](Measuring& m) { m.problem.struct_size -= 8; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(refused([](Measuring& m) { m.model.struct_size -= 8; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(refused([](Measuring& m) { m.result.struct_size += 8; }) == RVDNAV_ERROR_STRUCT_SIZE);
  CHECK(refused([](Measuring& m) { m.problem.model = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Measuring& m) { m.problem.start = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Measuring& m) { m.model.side_normals = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Measuring& m) { m.result.pose.gain = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Measuring& m) { m.result.taught_vector = nullptr; }) == RVDNAV_ERROR_NULL);
  CHECK(refused([](Measuring& m) { m.model.edge_count = RVDNAV_MAX_POSE_EDGES + 1; }) == RVDNAV_ERROR_CAPACITY);
  CHECK(refused([](Measuring& m) { m.model.face_count = RVDNAV_MAX_FACES + 1; }) == RVDNAV_ERROR_CAPACITY);
  CHECK(refused([](Measuring& m) { m.ends[3] = scene::kPoints; }) == RVDNAV_ERROR_TARGET);
  CHECK(refused([](Measuring& m) { m.ends[0] = m.ends[1]; }) == RVDNAV_ERROR_TARGET);
  CHECK(refused([](Measuring& m) { m.points[4] = kNone; }) == RVDNAV_ERROR_TARGET);
  CHECK(refused([](Measuring& m) { m.point_sigmas[2] = -1e-4; }) == RVDNAV_ERROR_TARGET);
  CHECK(refused([](Measuring& m) { m.model.edge_count = 7; }) == RVDNAV_ERROR_TARGET);  // of a bracket
  CHECK(refused([](Measuring& m) { m.problem.lasting_count -= 3; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Measuring& m) { m.polarity[5] = 2; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Measuring& m) { m.problem.scales[4] = 0.0; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Measuring& m) { m.problem.R_W_C[0] = kNone; }) == RVDNAV_ERROR_ARGUMENT);
  CHECK(refused([](Measuring& m) { m.problem.motion.row_seconds = -1e-6; }) == RVDNAV_ERROR_ARGUMENT);
  Measuring whole(kPlacement);
  CHECK(frame().measure(whole, nullptr, nullptr) == RVDNAV_ERROR_NULL);
  rvdnav_image narrow = frame().left;
  narrow.width -= 1;
  CHECK(frame().measure(whole, &narrow, nullptr) == RVDNAV_ERROR_IMAGE);
  size_t size = 0;
  uint32_t parameters = 0;
  REQUIRE(rvdnav_measure_size(frame().owner.context, &whole.problem, &size, &parameters) == RVDNAV_OK);
  CHECK(parameters == scene::kParameters);
  const Lent memory(size);
  CHECK(rvdnav_measure(frame().owner.context, &frame().left, &frame().right, &whole.problem, memory.data(), size - 1,
                       &whole.result) == RVDNAV_ERROR_MEMORY);
}

TEST_CASE("a measurement of what is not there ends in a status") {
  scene::Measuring behind(kPlacement);
  behind.problem.p_W[0] = -0.7;
  CHECK(frame().measure(behind) == RVDNAV_ERROR_BEHIND);
  scene::Measuring aside(kPlacement);
  aside.problem.p_W[1] = 5.0;
  CHECK(frame().measure(aside) == RVDNAV_ERROR_UNDETERMINED);
  scene::Measuring blank(kPlacement);
  const std::vector<uint8_t> grey(frame().pixels[0].size(), 90);
  const rvdnav_image image = scene::image(grey);
  CHECK(frame().measure(blank, &image, &image) == RVDNAV_ERROR_UNDETERMINED);
  scene::Measuring indefinite(kPlacement);
  indefinite.information[0] = -4.0;
  CHECK(frame().measure(indefinite) == RVDNAV_ERROR_UNDETERMINED);
}

TEST_CASE("a measurement with numbers of any size ends in a pose or in a status") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_int_distribution<size_t> any;
  int measured = 0;
  for (int round = 0; round < 150; ++round) {
    scene::Measuring m(kPlacement);
    const auto wild = [&] { return unit(random) * std::pow(10.0, 12.0 * unit(random)); };
    if (round % 2 == 0) m.model.bracket = 0;
    if (round % 3 == 0) {
      m.problem.motion.row_seconds = 1e-5;
      for (int i = 0; i < 6; ++i) m.problem.motion.covariance[7 * i] = 1e-4;
      for (double& sigma : m.point_sigmas) sigma = 0.0;
      m.problem.lasting_count = 0;
    }
    for (int changes = 0; changes < 2; ++changes) {
      double* const places[] = {&m.points[any(random) % m.points.size()],
                                &m.side_normals[any(random) % m.side_normals.size()],
                                &m.information[any(random) % m.information.size()],
                                &m.vector[any(random) % m.vector.size()],
                                &m.start[any(random) % m.start.size()],
                                &m.problem.p_W[any(random) % 3],
                                &m.problem.scales[any(random) % 5],
                                &m.model.thickness,
                                &m.problem.cameras.centre[0][any(random) % 3],
                                &m.problem.motion.velocity[any(random) % 6],
                                &m.problem.motion.covariance[any(random) % 36]};
      *places[any(random) % (sizeof places / sizeof *places)] = wild();
    }
    const rvdnav_status status = frame().measure(m);
    if (status != RVDNAV_OK) continue;
    ++measured;
    CHECK(std::isfinite(m.result.pose.p_W[2]));
    CHECK(std::isfinite(m.result.pose.covariance[0]));
    CHECK(std::isfinite(m.result.own_covariance[35]));
  }
  CHECK(measured > 30);
}
