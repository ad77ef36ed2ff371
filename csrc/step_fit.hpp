// Stage 7: the blurred step, with or without slopes beside it, that fits a profile of grey values.
#pragma once

#include <cstdint>

namespace rvdnav {

constexpr double kProfileSpacing = 0.5;  // pixels between the grey values of a profile
constexpr int32_t kMaxProfilePoints = 2 * 40 + 1;

// Grey values across an edge; t, pixels, rises in steps of kProfileSpacing and is 0 in the middle.
struct Profile {
  double t[kMaxProfilePoints];
  double grey[kMaxProfilePoints];
  int32_t count;
};

// What a step stands between: how far its two sides, towards -t and +t, are seen undisturbed, and the standard
// deviation of the grey's slope there as a part of the contrast a pixel (0: the grey is even on both sides).
struct Surroundings {
  double reach[2];  // pixels
  double slope[2];
  double blur_spread;  // standard deviation of the blur around the expected one, as a fraction
  double other;        // pixels from the step to the other edge of a bar that the blur reaches, 0: none
};

// face: width in pixels of the even face that the edge bounds, positive towards +t, negative towards -t, 0 unknown.
Surroundings surroundings(double face, double blur);

// How far from a step, pixels, its fit between these surroundings looks.
double reach_of(double face, double blur);

struct Step {
  double t0;
  double contrast;  // 0: unknown
  double blur;
  double sigma;  // standard deviation of t0, pixels
  double slope;  // the steeper of the two slopes, parts of the contrast a pixel
};

// The step near start, whose sigma and slope don't count, of the given blur in the profile (pixels).  False where there
// is none that stands out from the noise, or it lies beyond half_width - 1.
bool fit_step(const Profile& profile, double blur, double half_width, const Surroundings& around, const Step& start,
              Step* step);

}  // namespace rvdnav
