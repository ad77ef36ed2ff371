#include "interlace.hpp"

#include "integers.hpp"

namespace rvdnav {
namespace {

// Pieces of the image within which all edges move alike: pairs of rows, and columns.
constexpr int32_t kTileRows = 16, kTileColumns = 32;
// Where the grey changes by this much a pixel along the rows there is an edge, Q5, and by this many such pixels a tile
// shows one.
constexpr int16_t kSlope = 8 << 5;
constexpr int32_t kEdgePixels = 16;
// A tile is combed if its rows agree on a displacement by so many standard deviations of it, and it is above 0.08 px:
// 2/25, and of Q10 to Q9 the two.
constexpr int64_t kAgreement = 3;
constexpr int64_t kDisplacedDown = 25;
constexpr int32_t kRowStep = 8;  // grey levels from one row to the next that noise seldom makes
constexpr int32_t kMostMoved = 1 << 27;  // of a row, Q9: squared and summed over a tile, it stays within 64 bits

// Of one pair of rows of a tile: the difference between odd row and even ones times the slope, Q9, the squared slopes,
// Q10, and the pixels with an edge.
struct Comb {
  int32_t moved, square, edges;
};

// even: the even rows before last, last, next and after next; each from a column before the tile's first one to a
// column behind its last one.
Comb comb_row(const uint8_t* const* even, const uint8_t* odd) {
  int16_t between[kTileColumns + 2];  // the cubic through the even rows where the odd one lies, Q4
  for (int32_t i = 0; i < kTileColumns + 2; ++i) {
    between[i] = static_cast<int16_t>(9 * (even[1][i] + even[2][i]) - even[0][i] - even[3][i]);
  }
  Comb comb = {0, 0, 0};
  for (int32_t i = 0; i < kTileColumns; ++i) {
    const auto rise = static_cast<int16_t>(between[i + 2] - between[i]);
    const auto seen = static_cast<int16_t>(rise >= kSlope || rise <= -kSlope ? -1 : 0);
    const auto slope = static_cast<int16_t>(rise & seen);
    const auto apart = static_cast<int16_t>(between[i + 1] - 16 * odd[i + 1]);
    comb.moved += slope * apart;
    comb.square += slope * slope;
    comb.edges -= seen;
  }
  return comb;
}

// At the image's first and last column nothing is known of the slope: a pixel's own neighbour stands for the missing
// one.
void mirrored(const uint8_t* row, int32_t width, int32_t x, uint8_t* out) {
  for (int32_t i = 0; i < kTileColumns + 2; ++i) {
    const int32_t column = x - 1 + i;
    out[i] = row[column < 0 ? 1 : column < width ? column : width - 2];
  }
}

void count_tile(const GreyView& image, int32_t first_pair, int32_t x, rvdnav_fields* fields) {
  const int32_t pairs = image.height / 2;
  const bool inner = x > 0 && x + kTileColumns < image.width;
  int64_t total = 0, squares = 0, weight = 0;
  int32_t edges = 0;
  for (int32_t pair = first_pair; pair < first_pair + kTileRows; ++pair) {
    uint8_t border[5][kTileColumns + 2];
    const uint8_t* row[5];
    for (int32_t k = 0; k < 5; ++k) {
      const int32_t y = k < 4 ? 2 * clamp(pair - 1 + k, 0, pairs - 1) : 2 * pair + 1;
      row[k] = inner ? image.row(y) + x - 1 : border[k];
      if (!inner) mirrored(image.row(y), image.width, x, border[k]);
    }
    const Comb comb = comb_row(row, row[4]);
    const int64_t moved = clamp(comb.moved, -kMostMoved, kMostMoved);
    total += moved;
    squares += moved * moved;
    weight += comb.square;
    edges += comb.edges;
  }
  if (edges < kEdgePixels) return;
  ++fields->tiles;
  const int64_t size = total < 0 ? -total : total;
  const bool agreed = size * size > kAgreement * kAgreement * squares;
  if (agreed && kDisplacedDown * size > weight) ++fields->combed;
}

struct RowChange {
  uint32_t within, across;  // summed differences of a pair's rows, and of its second row and the next pair's first
};

// Where the next pair begins otherwise than this one ends by more than noise alone would have it.
RowChange row_change(const uint8_t* first, const uint8_t* second, const uint8_t* next, int32_t width) {
  RowChange change = {0, 0};
  for (int32_t x = 0; x < width; ++x) {
    const int32_t across = magnitude(second[x] - next[x]);
    const int32_t seen = across >= kRowStep ? -1 : 0;
    change.across += static_cast<uint32_t>(across & seen);
    change.within += static_cast<uint32_t>(magnitude(first[x] - second[x]) & seen);
  }
  return change;
}

}  // namespace

void find_fields(const GreyView& image, rvdnav_fields* fields) {
  fields->tiles = fields->combed = fields->row_pairs = fields->changed_pairs = fields->equal_pairs = 0;
  for (int32_t pair = 0; pair + kTileRows <= image.height / 2; pair += kTileRows) {
    for (int32_t x = 0; x + kTileColumns <= image.width; x += kTileColumns) count_tile(image, pair, x, fields);
  }
  for (int32_t y = 0; y + 3 < image.height; y += 2) {
    const RowChange change = row_change(image.row(y), image.row(y + 1), image.row(y + 2), image.width);
    ++fields->row_pairs;
    if (change.across == 0) continue;
    ++fields->changed_pairs;
    if (4 * change.within < change.across) ++fields->equal_pairs;
  }
}

}  // namespace rvdnav
