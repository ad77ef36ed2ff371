// Stage 3: the false-edge filter and thinning.  Bits as in stage 2; those beyond the width are 0.
#pragma once

#include "kernels/kernels.hpp"
#include "types.hpp"

namespace rvdnav {

constexpr int32_t kMaxMinRun = 64;

// Removes 8-connected components of fewer than min_run pixels (0..kMaxMinRun): specks and short runs.  kept: scratch of
// as many words as bits.  At most min_run pixels are looked at for each edge pixel.
void filter_edges(uint32_t* bits, int32_t w, int32_t h, int32_t min_run, const Kernels& kernels, uint32_t* kept);

// Work memory of thin.
struct ThinScratch {
  uint32_t* deletable;  // edge_row_words(w)
  uint32_t* empty;      // as many
  uint8_t* stale;       // h
};

// Thins to single-pixel edges: deletes simple pixels that are no ends, border by border, until there is none.  The
// 8-connected components stay the same in number (a pixel is simple if its deletion changes neither the components nor
// the holes).
void thin(uint32_t* bits, int32_t w, int32_t h, const Kernels& kernels, const ThinScratch& scratch);

}  // namespace rvdnav
