#include "pose/edge_lines.hpp"

#include <algorithm>
#include <cmath>

#include "math/elementary.hpp"
#include "math/order.hpp"

namespace rvdnav {
namespace {

constexpr int32_t kRounds = 8;
constexpr double kTukey = 4.685;  // 95 % efficient at a normal distribution
constexpr double kMadToSigma = 1.4826;
constexpr double kScaleFloor = 0.05;  // pixels
constexpr double kAgreeing = 0.1;     // weight from which a point agrees
constexpr double kMinAgreeing = 5.0;
constexpr double kTiny = 1e-300;  // in place of a zero that is divided by
// Neighbouring profiles share pixels, so they know less than independent ones would, by this factor in variance at
// least; those before an uneven background share more, which their residuals tell: up to this correlation.
constexpr double kLeastShared = 2.0;
constexpr double kLargestCorrelation = 0.9;
constexpr uint32_t kKeys = RVDNAV_CAMERAS * RVDNAV_MAX_POSE_EDGES;

uint32_t key_of(const rvdnav_edge_point& point) {
  return static_cast<uint32_t>(point.camera * RVDNAV_MAX_POSE_EDGES + point.edge);
}

// A line across one edge's points: offset + slope * along, and the sums of its weighted squares.
struct Fit {
  double offset, slope;
  double s0, s1, s2;  // of weight, weight * along, weight * along^2
  double det;
  bool determined;
};

// The points' places across and along their edge, from their mean; the normal is that of the first.
void place(const rvdnav_edge_point* points, const uint32_t* order, int32_t n, const EdgeLineMemory& m, double* centre) {
  const double nx = points[order[0]].nx, ny = points[order[0]].ny;
  centre[0] = centre[1] = 0.0;
  for (int32_t i = 0; i < n; ++i) {
    centre[0] += points[order[i]].x;
    centre[1] += points[order[i]].y;
  }
  centre[0] /= n;
  centre[1] /= n;
  for (int32_t i = 0; i < n; ++i) {
    const rvdnav_edge_point& p = points[order[i]];
    const double dx = p.x - centre[0], dy = p.y - centre[1];
    m.across[i] = nx * dx + ny * dy;
    m.along[i] = nx * dy - ny * dx;
    m.noise[i] = p.sigma * p.sigma;
  }
}

// One round of reweighted least squares.
void improve(int32_t n, const EdgeLineMemory& m, Fit* fit) {
  for (int32_t i = 0; i < n; ++i) {
    m.tukey[i] = m.across[i] - fit->offset - fit->slope * m.along[i];
    m.scratch[i] = std::fabs(m.tukey[i]);
  }
  const double scale = std::max(kMadToSigma * math::median(m.scratch, n), kScaleFloor);
  const double per_bound = 1.0 / (kTukey * scale);
  const double scatter = scale * scale;
  double s0 = 0.0, s1 = 0.0, s2 = 0.0, y0 = 0.0, y1 = 0.0;
  for (int32_t i = 0; i < n; ++i) {
    const double u = m.tukey[i] * per_bound;
    const double inside = std::max(1.0 - u * u, 0.0);
    m.tukey[i] = inside * inside;
    // Beyond its share of the scatter a point's own sigma tells how much it knows.
    const double w = m.tukey[i] / (m.noise[i] + scatter);
    m.weight[i] = w;
    const double wt = w * m.along[i], wy = w * m.across[i];
    s0 += w;
    s1 += wt;
    s2 += wt * m.along[i];
    y0 += wy;
    y1 += wy * m.along[i];
  }
  const double det = s0 * s2 - s1 * s1;
  const bool determined = det > 1e-9 * s0 * s2;
  const double offset = determined ? (s2 * y0 - s1 * y1) / det : fit->offset;
  const double slope = determined ? (s0 * y1 - s1 * y0) / det : 0.0;
  *fit = {offset, slope, s0, s1, s2, det, determined};
}

// By which factor the fit varies more than one of as many independent residuals would.  From the correlation r of
// neighbours, as if it fell off by r from each to the next, (1 + r) / (1 - r); a line through few residuals takes some
// of the correlation upon itself (M. G. Kendall, "Note on bias in the estimation of autocorrelation", 1954).
double shared(const double* residual, const double* weight, int32_t n, double agreeing) {
  double product = 0.0, square = 0.0;
  for (int32_t i = 1; i < n; ++i) {
    const double both = weight[i] * weight[i - 1];
    product += both * residual[i] * residual[i - 1];
    square += 0.5 * both * (residual[i] * residual[i] + residual[i - 1] * residual[i - 1]);
  }
  const double count = std::max(agreeing, 2.0 * kMinAgreeing);
  const double found = (count * product / std::max(square, kTiny) + 2.0) / (count - 4.0);
  const double correlation = std::min(std::max(found, 0.0), kLargestCorrelation);
  return std::max((1.0 + correlation) / (1.0 - correlation), kLeastShared);
}

// The line in the image, with covariance and scatter; false if too few points agree on it.
bool finish(const Fit& fit, int32_t n, const EdgeLineMemory& m, const rvdnav_edge_point& first, const double* centre,
            rvdnav_edge_line* line) {
  double agreeing = 0.0, squares = 0.0, plain_squares = 0.0, plain = 0.0;
  double* residual = m.scratch;
  for (int32_t i = 0; i < n; ++i) {
    residual[i] = m.across[i] - fit.offset - fit.slope * m.along[i];
    const double square = residual[i] * residual[i];
    agreeing += m.tukey[i] > kAgreeing ? 1.0 : 0.0;
    squares += m.weight[i] * square;
    plain_squares += m.tukey[i] * square;
    plain += m.tukey[i];
  }
  if (!fit.determined || agreeing < kMinAgreeing) return false;
  const double unit = squares / (agreeing - 2.0) * agreeing / fit.s0;
  const double variance = std::max(unit, kScaleFloor * kScaleFloor / 4.0) * shared(residual, m.tukey, n, agreeing);
  // Var of (offset, slope) = factor [[s2, -s1], [-s1, s0]], turned into (rho, theta).
  const double factor = variance * (fit.s0 / agreeing) / fit.det;
  const double theta = math::atan2(first.ny, first.nx) - math::atan(fit.slope);
  const double c = math::cos(theta), s = math::sin(theta);
  const double x = centre[0] + fit.offset * first.nx, y = centre[1] + fit.offset * first.ny;
  const double middle = y * c - x * s;
  const double mixed = factor * (fit.s1 + middle * fit.s0);
  *line = {first.camera,
           first.edge,
           c * x + s * y,
           theta,
           {factor * (fit.s2 + 2.0 * middle * fit.s1 + middle * middle * fit.s0), mixed, mixed, factor * fit.s0},
           std::sqrt(plain_squares / plain)};
  return true;
}

bool fit_line(const rvdnav_edge_point* points, const uint32_t* order, int32_t n, const EdgeLineMemory& m,
              rvdnav_edge_line* line) {
  double centre[2];
  place(points, order, n, m, centre);
  std::copy(m.across, m.across + n, m.scratch);
  Fit fit = {math::median(m.scratch, n), 0.0, 0.0, 0.0, 0.0, 0.0, false};
  for (int32_t round = 0; round < kRounds; ++round) improve(n, m, &fit);
  return finish(fit, n, m, points[order[0]], centre, line);
}

// Sorts the points by key, those of a key in the order given: begin[k] .. begin[k + 1] are those of key k.
void group(const rvdnav_edge_point* points, uint32_t count, uint32_t* order, uint32_t (&begin)[kKeys + 1]) {
  std::fill(begin, begin + kKeys + 1, 0u);
  for (uint32_t i = 0; i < count; ++i) ++begin[key_of(points[i]) + 1];
  for (uint32_t k = 0; k < kKeys; ++k) begin[k + 1] += begin[k];
  // Each key's beginning moves to its end, which is the next one's beginning.
  for (uint32_t i = 0; i < count; ++i) order[begin[key_of(points[i])]++] = i;
  for (uint32_t k = kKeys; k > 0; --k) begin[k] = begin[k - 1];
  begin[0] = 0;
}

}  // namespace

void lay_out(uint32_t point_count, Arena& arena, EdgeLineMemory* memory) {
  arena.take(&memory->order, point_count);
  for (double** array :
       {&memory->across, &memory->along, &memory->noise, &memory->weight, &memory->tukey, &memory->scratch}) {
    arena.take(array, point_count);
  }
}

uint32_t fit_edge_lines(const rvdnav_edge_point* points, uint32_t point_count, const EdgeLineMemory& memory,
                        rvdnav_edge_line* lines, uint32_t capacity, double* weights, uint32_t* total) {
  uint32_t begin[kKeys + 1];
  group(points, point_count, memory.order, begin);
  std::fill(weights, weights + point_count, 0.0);
  uint32_t written = 0;
  *total = 0;
  for (uint32_t k = 0; k < kKeys; ++k) {
    const uint32_t* order = memory.order + begin[k];
    const int32_t n = static_cast<int32_t>(begin[k + 1] - begin[k]);
    rvdnav_edge_line line;
    if (n == 0 || !fit_line(points, order, n, memory, &line)) continue;
    for (int32_t i = 0; i < n; ++i) weights[order[i]] = memory.tukey[i];
    ++*total;
    if (written < capacity) lines[written++] = line;
  }
  return written;
}

}  // namespace rvdnav
