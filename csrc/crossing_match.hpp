// Zero crossings of both views matched along the rows, from the coarsest level to the finest.
#pragma once

#include "zero_crossings.hpp"

namespace rvdnav {

struct CrossingLimits {
  int32_t half_window;      // of the grey windows compared, pixels
  int32_t min_score_q15;    // least ZNCC
  int32_t uniqueness_q8;    // a rival's score must stay below this fraction of the best
  int32_t max_gradient_q8;  // of the disparity
};

constexpr int32_t kTile = 8;  // pixels

// Disparities found in a tile of a level, pixels; none where high < low.
struct DisparityTile {
  int16_t low, high;
};

constexpr int32_t tiles_over(int32_t size) { return (size + kTile - 1) / kTile; }

// The disparities of a level, as the next finer one sees them.
struct DisparityTiles {
  DisparityTile* tiles;  // row-major
  int32_t columns, rows;
};

struct CrossingMatch {
  int32_t right;  // index of the right crossing, -1: none
  int32_t score_q15;
};

// Work memory of a level's matching.
struct CrossingScratch {
  int32_t* right_score;  // a right crossing's best so far
  int32_t* right_left;   // and whose it is
  uint8_t* keep;         // of the left crossings
};

// Matches the left crossings of a level, the same in both views (matches: one each).  Disparities lie in low .. high
// pixels of the level, and near those of the coarser level's tiles around where there are any (coarse may be null).  A
// match is the best of both crossings, has a score, no rival nearly as good, and neighbours within the disparity
// gradient.
void match_crossings(const LevelView& left, const LevelView& right, int32_t low, int32_t high,
                     const DisparityTiles* coarse, const CrossingLimits& limits, const CrossingScratch& scratch,
                     CrossingMatch* matches);

// What a level's matches tell the next finer one.
void fill_tiles(const LevelView& left, const LevelView& right, const CrossingMatch* matches, DisparityTiles* tiles);

}  // namespace rvdnav
