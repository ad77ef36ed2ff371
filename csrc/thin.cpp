#include "thin.hpp"

#include "integers.hpp"
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

// A small window of edge pixels in one word: rows y - 1 to y + 4, columns x - 4 to x + 4, and a column of zeros after
// each row's.
class SmallWindow {
 public:
  static constexpr uint64_t kTop = 0x1ff;               // the first row
  static constexpr uint64_t kEnds = 0x7fd014050140501;  // the first and the last column, and the last row

  SmallWindow(int32_t words, int32_t h, int32_t x, int32_t y)
      : words_(words), first_(y > 0 ? 0 : 1), last_(smaller(kRows - 1, h - y)), y_(y - 1) {
    const int32_t left = x - kReach;
    k_ = left >= 0 ? left / 32 : -1;
    shift_ = left - 32 * k_;
  }

  uint64_t pixels(const uint32_t* bits) const {
    uint64_t window = 0;
    for (int32_t r = first_; r <= last_; ++r) {
      const uint32_t* row = bits + static_cast<ptrdiff_t>(y_ + r) * words_;
      const uint64_t low = k_ >= 0 ? row[k_] : 0, high = k_ + 1 < words_ ? row[k_ + 1] : 0;
      window |= ((high << 32 | low) >> shift_ & kTop) << (r * kStride);
    }
    return window;
  }

  // Calls change(word, mask) for the words that hold the window's pixels.
  template <typename Change>
  void for_each_word(uint32_t* bits, uint64_t window, Change change) const {
    for (int32_t r = first_; r <= last_; ++r) {
      uint32_t* row = bits + static_cast<ptrdiff_t>(y_ + r) * words_;
      const uint64_t mask = (window >> (r * kStride) & kTop) << shift_;
      if (static_cast<uint32_t>(mask) != 0) change(row[k_], static_cast<uint32_t>(mask));
      if (mask >> 32 != 0) change(row[k_ + 1], static_cast<uint32_t>(mask >> 32));
    }
  }

  // The pixels that hang together with the one in the window's middle, up to the first that make `enough`.
  static uint64_t component(uint64_t pixels, int32_t enough) {
    uint64_t found = uint64_t{1} << (kStride + kReach);
    for (uint64_t before = 0; before != found && __builtin_popcountll(found) < enough;) {
      before = found;
      found |= found << 1 | found >> 1;
      found |= found << kStride | found >> kStride;
      found &= pixels;
    }
    return found;
  }

 private:
  static constexpr int32_t kReach = 4, kStride = 2 * kReach + 2, kRows = 6;

  int32_t words_, first_, last_, y_, k_, shift_;
};

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

// Thinning in sweeps.  One layer goes from two borders: the edges' north and west, or their south and east.  A sweep
// runs against them, so that a pixel's neighbour on that side is still what it was before; the pixels are tested again
// as their other neighbours go.  A row is swept again only if it or a row beside it has changed.
class Thinning {
 public:
  Thinning(uint32_t* bits, int32_t w, int32_t h, const Kernels& kernels, const ThinScratch& scratch)
      : bits_(bits), w_(w), h_(h), words_(edge_row_words(w)), kernels_(kernels), scratch_(scratch) {
    for (int32_t k = 0; k < words_; ++k) scratch_.empty[k] = 0;
    for (int32_t y = 0; y < h_; ++y) scratch_.stale[y] = kBoth;
  }

  // Whether anything has changed.
  bool sweep(Borders borders) {
    const bool north_west = borders == Borders::kNorthWest;
    const uint8_t mark = north_west ? kForNorthWest : kForSouthEast;
    bool changed = false;
    for (int32_t i = 0; i < h_; ++i) {
      const int32_t y = north_west ? h_ - 1 - i : i;
      if ((scratch_.stale[y] & mark) == 0) continue;
      scratch_.stale[y] &= static_cast<uint8_t>(~mark);
      if (!peel_row(y, borders)) continue;
      changed = true;
      for (int32_t near = larger(y - 1, 0); near <= smaller(y + 1, h_ - 1); ++near) scratch_.stale[near] = kBoth;
    }
    return changed;
  }

 private:
  static constexpr uint8_t kForNorthWest = 1, kForSouthEast = 2, kBoth = 3;

  bool peel_row(int32_t y, Borders borders) {
    uint32_t* row = bits_ + static_cast<ptrdiff_t>(y) * words_;
    const uint32_t* above = y > 0 ? row - words_ : scratch_.empty;
    const uint32_t* below = y + 1 < h_ ? row + words_ : scratch_.empty;
    if (!kernels_.deletable_row(above, row, below, words_, borders, scratch_.deletable)) return false;
    const bool north_west = borders == Borders::kNorthWest;
    // The pixel beside the word before, which must be looked at anew when that word's nearest pixel has gone.
    const uint32_t seam = north_west ? uint32_t{1} << 31 : 1, nearest = north_west ? 1 : uint32_t{1} << 31;
    bool seam_changed = false, changed = false;
    for (int32_t j = 0; j < words_; ++j) {
      const int32_t k = north_west ? words_ - 1 - j : j;
      uint32_t chosen = scratch_.deletable[k];
      if (seam_changed) chosen = (chosen & ~seam) | (on_border(k, y, seam, borders) ? seam : 0);
      const uint32_t gone = chosen != 0 ? remove(k, y, chosen) : 0;
      seam_changed = (gone & nearest) != 0;
      changed = changed || gone != 0;
    }
    return changed;
  }

  // Removes the chosen pixels that are still deletable when it is their turn, from west to east; returns them.
  uint32_t remove(int32_t k, int32_t y, uint32_t chosen) {
    uint32_t& word = bits_[static_cast<ptrdiff_t>(y) * words_ + k];
    uint32_t gone = chosen & ~(chosen << 1);  // nothing has changed beside these
    word &= ~gone;
    for (uint32_t rest = chosen & ~gone; rest != 0; rest &= rest - 1) {
      const uint32_t pixel = rest & (0 - rest);
      if (!kDeletable.value[neighbours(k, y, pixel)]) continue;
      word &= ~pixel;
      gone |= pixel;
    }
    return gone;
  }

  bool on_border(int32_t k, int32_t y, uint32_t pixel, Borders borders) const {
    const uint32_t n = neighbours(k, y, pixel);
    const uint32_t inner = borders == Borders::kNorthWest ? (n >> 6 & n >> 4) : (n >> 2 & n);
    const bool set = (bits_[static_cast<ptrdiff_t>(y) * words_ + k] & pixel) != 0;
    return set && kDeletable.value[n] && (inner & 1) == 0;
  }

  uint32_t neighbours(int32_t k, int32_t y, uint32_t pixel) const {
    return neighbours_of(bits_, w_, h_, 32 * k + lowest_bit(pixel), y);
  }

  uint32_t* bits_;
  int32_t w_, h_, words_;
  const Kernels& kernels_;
  const ThinScratch& scratch_;
};

// Judges the component of (x, y) by what lies around it: its pixels there are kept or gone.  False if more must be
// seen. Rows above y hold kept pixels alone.
bool judge_in_window(uint32_t* bits, uint32_t* kept, int32_t words, int32_t h, int32_t x, int32_t y, int32_t min_run) {
  const SmallWindow window(words, h, x, y);
  const uint64_t found = SmallWindow::component(window.pixels(bits), min_run);
  if ((found & SmallWindow::kTop) != 0 || __builtin_popcountll(found) >= min_run) {
    window.for_each_word(kept, found, [](uint32_t& word, uint32_t mask) { word |= mask; });
    return true;
  }
  if ((found & SmallWindow::kEnds) != 0) return false;
  window.for_each_word(bits, found, [](uint32_t& word, uint32_t mask) { word &= ~mask; });
  return true;
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

void filter_edges(uint32_t* bits, int32_t w, int32_t h, int32_t min_run, const Kernels& kernels, uint32_t* kept) {
  if (min_run <= 1) return;
  const int32_t words = edge_row_words(w);
  for (ptrdiff_t i = 0; i < static_cast<ptrdiff_t>(words) * h; ++i) kept[i] = 0;
  Bits edges(bits, w, h), keepers(kept, w, h);
  for (int32_t y = 0; y < h; ++y) {
    const ptrdiff_t row = static_cast<ptrdiff_t>(y) * words;
    // Most pixels go on with an edge that is already kept.
    if (y > 0 && !kernels.touching_row(bits + row, kept + row - words, words, kept + row)) continue;
    for (int32_t k = 0; k < words; ++k) {
      const ptrdiff_t i = row + k;
      if ((bits[i] & ~kept[i]) == 0) continue;
      kept[i] |= touching(bits[i], neighbours_of_word(kept, words, h, k, y));
      while ((bits[i] & ~kept[i]) != 0) {
        const int32_t x = 32 * k + lowest_bit(bits[i] & ~kept[i]);
        if (!judge_in_window(bits, kept, words, h, x, y, min_run)) judge_component(edges, keepers, x, y, min_run);
      }
    }
  }
}

void thin(uint32_t* bits, int32_t w, int32_t h, const Kernels& kernels, const ThinScratch& scratch) {
  Thinning thinning(bits, w, h, kernels, scratch);
  for (bool changed = true; changed;) {
    changed = thinning.sweep(Borders::kNorthWest);
    changed = thinning.sweep(Borders::kSouthEast) || changed;
  }
}

}  // namespace rvdnav
