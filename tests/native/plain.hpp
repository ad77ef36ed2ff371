// What the tests of the integer stages share: a fixed stream of random numbers, bit images, flood fill.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "types.hpp"

namespace plain {

// The sanitizers make a scene many times slower; under them fewer do.
#if defined(__SANITIZE_ADDRESS__)
constexpr int scenes(int n) { return (n + 3) / 4; }
#else
constexpr int scenes(int n) { return n; }
#endif

// A linear congruential generator: the same numbers everywhere.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed * 2654435761u + 12345) {}
  uint32_t next() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<uint32_t>(state_ >> 33);
  }
  int32_t between(int32_t low, int32_t high) {
    return low + static_cast<int32_t>(next() % static_cast<uint32_t>(high - low + 1));
  }
  double real(double low, double high) { return low + (high - low) * (next() / 2147483648.0); }

 private:
  uint64_t state_;
};

struct Grey {
  int32_t w, h;
  std::vector<uint8_t> pixels;
  Grey(int32_t width, int32_t height, uint8_t value = 0)
      : w(width), h(height), pixels(static_cast<size_t>(width) * static_cast<size_t>(height), value) {}
  size_t index(int32_t x, int32_t y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(w) + static_cast<size_t>(x);
  }
  uint8_t& at(int32_t x, int32_t y) { return pixels[index(x, y)]; }
  int32_t at(int32_t x, int32_t y) const { return pixels[index(x, y)]; }
  rvdnav::GreyView view() const { return {pixels.data(), w, h, w}; }
};

inline Grey random_grey(Random& random, int32_t w, int32_t h, int32_t low = 0, int32_t high = 255) {
  Grey image(w, h);
  for (uint8_t& p : image.pixels) p = static_cast<uint8_t>(random.between(low, high));
  return image;
}

// Packed edge bits with a plain face.
struct BitImage {
  int32_t w, h;
  std::vector<uint32_t> words;
  BitImage(int32_t width, int32_t height)
      : w(width),
        h(height),
        words(static_cast<size_t>(rvdnav::edge_row_words(width)) * static_cast<size_t>(height), 0) {}
  size_t word(int32_t x, int32_t y) const {
    return static_cast<size_t>(y) * static_cast<size_t>(rvdnav::edge_row_words(w)) + static_cast<size_t>(x / 32);
  }
  bool get(int32_t x, int32_t y) const {
    return x >= 0 && y >= 0 && x < w && y < h && (words[word(x, y)] >> (x % 32) & 1) != 0;
  }
  void put(int32_t x, int32_t y, bool value) {
    const uint32_t bit = uint32_t{1} << (x % 32);
    words[word(x, y)] = value ? words[word(x, y)] | bit : words[word(x, y)] & ~bit;
  }
  int32_t count() const {
    int32_t n = 0;
    for (int32_t y = 0; y < h; ++y)
      for (int32_t x = 0; x < w; ++x) n += get(x, y) ? 1 : 0;
    return n;
  }
  bool operator==(const BitImage& other) const { return w == other.w && h == other.h && words == other.words; }
};

inline BitImage random_bits(Random& random, int32_t w, int32_t h, int32_t percent) {
  BitImage bits(w, h);
  for (int32_t y = 0; y < h; ++y)
    for (int32_t x = 0; x < w; ++x) bits.put(x, y, random.between(0, 99) < percent);
  return bits;
}

using Component = std::vector<std::pair<int32_t, int32_t>>;

// Connected components of the pixels with the given value, by flood fill.  Background is looked at with a frame of one
// pixel around the image.
inline std::vector<Component> components(const BitImage& bits, bool value, bool eight) {
  const int32_t w = bits.w + 2, h = bits.h + 2;
  std::vector<bool> seen(static_cast<size_t>(w * h), false);
  std::vector<Component> found;
  const auto wanted = [&](int32_t x, int32_t y) { return bits.get(x - 1, y - 1) == value; };
  for (int32_t y0 = 0; y0 < h; ++y0) {
    for (int32_t x0 = 0; x0 < w; ++x0) {
      if (seen[static_cast<size_t>(y0 * w + x0)] || !wanted(x0, y0)) continue;
      Component component = {{x0 - 1, y0 - 1}};
      seen[static_cast<size_t>(y0 * w + x0)] = true;
      for (size_t i = 0; i < component.size(); ++i) {
        for (int32_t dy = -1; dy <= 1; ++dy) {
          for (int32_t dx = -1; dx <= 1; ++dx) {
            if (!eight && dx != 0 && dy != 0) continue;
            const int32_t x = component[i].first + 1 + dx, y = component[i].second + 1 + dy;
            if (x < 0 || y < 0 || x >= w || y >= h || seen[static_cast<size_t>(y * w + x)] || !wanted(x, y)) continue;
            seen[static_cast<size_t>(y * w + x)] = true;
            component.emplace_back(x - 1, y - 1);
          }
        }
      }
      found.push_back(component);
    }
  }
  return found;
}

}  // namespace plain
