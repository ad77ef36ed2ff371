// What is done to single edge pixels, in plain loops; include inside a namespace of the instruction set's own, which
// may use some of it.

[[maybe_unused]] static void gradient_levels(const uint8_t* smoothed, int32_t width, const uint32_t* pixels,
                                             int32_t count, uint8_t* levels) {
  for (int32_t i = 0; i < count; ++i) {
    const auto x = static_cast<int32_t>(pixels[i] & 0xffff), y = static_cast<int32_t>(pixels[i] >> 16);
    const uint8_t* p = smoothed + static_cast<ptrdiff_t>(y) * width + x;
    const uint8_t* a = p - width;
    const uint8_t* c = p + width;
    const int32_t gx = (a[1] + 2 * p[1] + c[1]) - (a[-1] + 2 * p[-1] + c[-1]);
    const int32_t gy = (c[-1] + 2 * c[0] + c[1]) - (a[-1] + 2 * a[0] + a[1]);
    levels[i] = binary_angle(gx, gy);
  }
}

[[maybe_unused]] static int32_t rectify_pixels(const LensMap& map, const uint32_t* pixels, const uint8_t* levels,
                                               int32_t count, rvdnav_edgel* out) {
  int32_t written = 0;
  for (int32_t i = 0; i < count; ++i) {
    const int32_t u = 32 * static_cast<int32_t>(pixels[i] & 0xffff), v = 32 * static_cast<int32_t>(pixels[i] >> 16);
    const int32_t du = kTangent.step[levels[i]].dx, dv = kTangent.step[levels[i]].dy;
    int32_t rx = 0, ry = 0, ahead_x = 0, ahead_y = 0, behind_x = 0, behind_y = 0;
    if (!raw_to_rect_q5(map, u, v, &rx, &ry) || !raw_to_rect_q5(map, u + du, v + dv, &ahead_x, &ahead_y) ||
        !raw_to_rect_q5(map, u - du, v - dv, &behind_x, &behind_y))
      continue;
    const int32_t tx = ahead_x - behind_x, ty = ahead_y - behind_y;
    // The gradient is a quarter turn behind the tangent.
    out[written++] = {rx, ry, binary_angle(ty, -tx), {}};
  }
  return written;
}

// Votes of an edgel in `rows` rows from the first one on, which may be one of the second half turn.
[[maybe_unused]] static void vote_some(const rvdnav_edgel& e, int32_t rho_bins, int32_t first, int32_t rows,
                                       uint16_t* acc) {
  // Products of Q5 and Q14 are Q19; the offset takes rho to the middle cell and rounds.
  const int64_t offset = (int64_t{rho_bins / 2} << 19) + (1 << 18);
  for (int32_t row = first; row < first + rows; ++row) {
    const int64_t rho = int64_t{e.x_q5} * kHoughRows.c[row] + int64_t{e.y_q5} * kHoughRows.s[row] + offset;
    const int64_t cell = rho >= 0 ? rho >> 19 : rho_bins;
    const int32_t own = row < kThetaBins ? row : row - kThetaBins;
    if (cell < rho_bins) ++acc[static_cast<ptrdiff_t>(own) * rho_bins + cell];
  }
}

[[maybe_unused]] static void vote(const rvdnav_edgel* edgels, uint32_t count, int32_t rho_bins, int32_t spread,
                                  uint16_t* acc) {
  for (uint32_t i = 0; i < count; ++i) {
    const int32_t first = theta_row(edgels[i].direction) - spread;
    vote_some(edgels[i], rho_bins, first < 0 ? first + kThetaBins : first, 2 * spread + 1, acc);
  }
}
