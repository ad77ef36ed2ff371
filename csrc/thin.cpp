#include "thin.hpp"

#include "neighbours.hpp"

namespace rvdnav {
namespace {

struct Pixel {
  int16_t x, y;
};

// Offsets of the neighbours, in the order of neighbours_of.
constexpr int8_t kStepX[8] = {1, 1, 0, -1, -1, -1, 0, 1};
constexpr int8_t kStepY[8] = {0, 1, 1, 1, 0, -1, -1, -1};

class Bits {
 public:
  Bits(uint32_t* bits, int32_t w, int32_t h) : bits_(bits), w_(w), h_(h), words_(edge_row_words(w)) {}
  uint32_t neighbours(int32_t x, int32_t y) const { return neighbours_of(bits_, w_, h_, x, y); }
  void set(int32_t x, int32_t y) { word(x, y) |= uint32_t{1} << (x % 32); }
  void clear(int32_t x, int32_t y) { word(x, y) &= ~(uint32_t{1} << (x % 32)); }

 private:
  uint32_t& word(int32_t x, int32_t y) { return bits_[static_cast<ptrdiff_t>(y) * words_ + x / 32]; }
  uint32_t* bits_;
  int32_t w_, h_, words_;
};

int32_t lowest_bit(uint32_t word) { return __builtin_ctz(word); }

// Grows the component of (x, y) until it is known to be long enough; its pixels are then kept, else they are gone.
void judge_component(Bits& bits, Bits& kept, int32_t x, int32_t y, int32_t min_run) {
  Pixel found[kMaxMinRun];
  int32_t count = 0;
  const auto take = [&](int32_t px, int32_t py) {
    bits.clear(px, py);
    found[count++] = {static_cast<int16_t>(px), static_cast<int16_t>(py)};
  };
  take(x, y);
  bool long_enough = count >= min_run;
  for (int32_t next = 0; next < count && !long_enough; ++next) {
    const Pixel p = found[next];
    long_enough = kept.neighbours(p.x, p.y) != 0;
    for (uint32_t around = bits.neighbours(p.x, p.y); around != 0 && !long_enough; around &= around - 1) {
      const int32_t k = lowest_bit(around);
      take(p.x + kStepX[k], p.y + kStepY[k]);
      long_enough = count >= min_run;
    }
  }
  for (int32_t i = 0; long_enough && i < count; ++i) {
    bits.set(found[i].x, found[i].y);
    kept.set(found[i].x, found[i].y);
  }
}

// Whether a pixel with these neighbours may go: simple and no end.  Simple, with 8-connected edges on a 4-connected
// background: the background runs past its four sides exactly once (Hilditch's crossing number).
constexpr bool deletable(uint32_t n) {
  int runs = 0, edges = 0;
  for (uint32_t k = 0; k < 8; ++k) edges += static_cast<int>(n >> k & 1);
  for (uint32_t k = 0; k < 8; k += 2) {
    const bool side = n >> k & 1, corner = n >> (k + 1) & 1, next_side = n >> ((k + 2) & 7) & 1;
    runs += !side && (corner || next_side) ? 1 : 0;
  }
  return runs == 1 && edges >= 2;
}

struct DeletableTable {
  bool value[256];
};

constexpr DeletableTable make_deletable_table() {
  DeletableTable table = {};
  for (uint32_t n = 0; n < 256; ++n) table.value[n] = deletable(n);
  return table;
}

constexpr DeletableTable kDeletable = make_deletable_table();

// The same test for 32 pixels at once.
uint32_t deletable_pixels(uint32_t pixels, const Around& around) {
  const uint32_t* n = around.n;
  uint32_t one_run = 0, more_runs = 0, one_edge = 0, more_edges = 0;
  for (int k = 0; k < 8; k += 2) {
    const uint32_t run = ~n[k] & (n[k + 1] | n[(k + 2) & 7]);
    more_runs |= one_run & run;
    one_run |= run;
  }
  for (int k = 0; k < 8; ++k) {
    more_edges |= one_edge & n[k];
    one_edge |= n[k];
  }
  return pixels & one_run & ~more_runs & more_edges;
}

// One layer goes from two borders: the edges' north and west, or their south and east.  The sweep runs against them, so
// that a pixel's neighbour on that side is still what it was before; the pixels are tested again one by one, as their
// other neighbours go.
bool peel(uint32_t* bits, int32_t w, int32_t h, bool north_west) {
  const int32_t words = edge_row_words(w);
  Bits edges(bits, w, h);
  bool changed = false;
  for (int32_t i = 0; i < h; ++i) {
    const int32_t y = north_west ? h - 1 - i : i;
    const uint32_t* row = bits + static_cast<ptrdiff_t>(y) * words;
    for (int32_t j = 0; j < words; ++j) {
      const int32_t k = north_west ? words - 1 - j : j;
      if (row[k] == 0) continue;
      const Around around = neighbours_of_word(bits, words, h, k, y);
      const uint32_t inner = north_west ? around.n[6] & around.n[4] : around.n[2] & around.n[0];
      for (uint32_t rest = deletable_pixels(row[k], around) & ~inner; rest != 0; rest &= rest - 1) {
        const int32_t x = 32 * k + lowest_bit(rest);
        if (!kDeletable.value[edges.neighbours(x, y)]) continue;
        edges.clear(x, y);
        changed = true;
      }
    }
  }
  return changed;
}

// Those of the pixels that touch kept ones, through each other as well.
uint32_t touching(uint32_t pixels, const Around& kept) {
  uint32_t reached = 0;
  for (int k = 0; k < 8; ++k) reached |= kept.n[k];
  reached &= pixels;
  for (uint32_t before = 0; before != reached;) {
    before = reached;
    reached |= (reached << 1 | reached >> 1) & pixels;
  }
  return reached;
}

}  // namespace

void filter_edges(uint32_t* bits, int32_t w, int32_t h, int32_t min_run, uint32_t* kept) {
  if (min_run <= 1) return;
  const int32_t words = edge_row_words(w);
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(words) * h; ++i) kept[i] = 0;
  Bits edges(bits, w, h), keepers(kept, w, h);
  for (int32_t y = 0; y < h; ++y) {
    for (int32_t k = 0; k < words; ++k) {
      const ptrdiff_t i = static_cast<ptrdiff_t>(y) * words + k;
      if (bits[i] == 0) continue;
      // Most pixels go on with an edge that is already kept.
      kept[i] |= touching(bits[i], neighbours_of_word(kept, words, h, k, y));
      while ((bits[i] & ~kept[i]) != 0) {
        judge_component(edges, keepers, 32 * k + lowest_bit(bits[i] & ~kept[i]), y, min_run);
      }
    }
  }
}

void thin(uint32_t* bits, int32_t w, int32_t h) {
  bool changed = true;
  while (changed) {
    changed = peel(bits, w, h, true);
    changed = peel(bits, w, h, false) || changed;
  }
}

}  // namespace rvdnav
