// What the parts of the harness share: numbers from the input, structures disturbed by them, memory of exactly the size
// asked for, images.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "rvdnav/rvdnav.h"

// Bytes of the input, zeros when it is used up.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  template <typename T>
  T take() {
    T value = {};
    const size_t n = size_ < sizeof(T) ? size_ : sizeof(T);
    if (n > 0) std::memcpy(&value, data_, n);
    data_ += n;
    size_ -= n;
    return value;
  }
  // One of the numbers below n.
  uint32_t below(uint32_t n) { return take<uint8_t>() % n; }
  // Rarely, one in n, and not where the input is used up.
  bool one_in(uint32_t n) { return below(n) == n - 1; }
  // A number of any kind: the bits of one, or a small one.
  double real() { return one_in(2) ? take<double>() : take<int16_t>() / 256.0; }

 private:
  const uint8_t* data_;
  size_t size_;
};

struct Free {
  void operator()(void* p) const { std::free(p); }
};
using Memory = std::unique_ptr<void, Free>;

[[noreturn]] inline void broken() { std::abort(); }

inline void require(bool holds) {
  if (!holds) broken();
}

inline Memory aligned(size_t size) {
  void* memory = nullptr;
  require(posix_memalign(&memory, 64, size) == 0);
  return Memory(memory);
}

// Overwrites up to `most` aligned words of the bytes [first, end) of what begins at `out`.
inline void disturb(Input& input, uint32_t most, size_t first, size_t end, void* out) {
  auto* bytes = static_cast<uint8_t*>(out);
  for (uint32_t n = input.below(most + 1); n > 0; --n) {
    const uint32_t kind = input.below(4);
    const size_t at = first + 4 * (input.take<uint16_t>() % ((end - first) / 4)), pair = at / 8 * 8;
    if (kind < 2) {
      const int32_t value = kind == 0 ? input.take<int32_t>() : input.take<int8_t>();
      std::memcpy(bytes + at, &value, sizeof value);
    } else if (pair >= first && pair + 8 <= end) {
      const double value = kind == 2 ? input.take<double>() : input.take<int16_t>() / 256.0;
      std::memcpy(bytes + pair, &value, sizeof value);
    }
  }
}

// The numbers of a structure that begins with struct_size, and of structures that don't.
template <typename T>
void disturb_sized(Input& input, uint32_t most, T* out) {
  disturb(input, most, sizeof(uint32_t), sizeof(T), out);
}
template <typename T>
void disturb_all(Input& input, uint32_t most, std::vector<T>* out) {
  if (!out->empty()) disturb(input, most, 0, out->size() * sizeof(T), out->data());
}

// Noise that takes four bytes of the input.
class Noise {
 public:
  explicit Noise(Input& input) : state_(input.take<uint32_t>()) {}

  uint32_t next() {
    state_ = state_ * 1664525U + 1013904223U;
    return state_ >> 16;
  }
  double real() { return next() / 32768.0 - 1.0; }

 private:
  uint32_t state_;
};

// Rectangles, one on another, and noise, in exactly as much memory as the rows need.
class Picture {
 public:
  Picture(Input& input, int32_t width, int32_t height, int32_t stride)
      : pixels_(static_cast<size_t>(stride) * static_cast<size_t>(height - 1) + static_cast<size_t>(width),
                input.take<uint8_t>()),
        image_{pixels_.data(), width, height, stride} {
    for (uint32_t n = input.below(16); n > 0; --n) rectangle(input);
    const uint32_t noise = input.below(32);
    Noise random(input);
    for (uint8_t& p : pixels_) {
      if (noise > 0) p = static_cast<uint8_t>(p + random.next() % noise);
    }
  }
  Picture(Input& input, const rvdnav_rig& rig) : Picture(input, rig.width, rig.height, rig.width) {}
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;

  const rvdnav_image* image() const { return &image_; }

 private:
  void rectangle(Input& input) {
    const int32_t x = input.take<uint8_t>() % image_.width, y = input.take<uint8_t>() % image_.height;
    const int32_t w = input.take<uint8_t>(), h = input.take<uint8_t>();
    const uint8_t grey = input.take<uint8_t>();
    for (int32_t v = y; v < image_.height && v < y + h; ++v) {
      for (int32_t u = x; u < image_.width && u < x + w; ++u) {
        pixels_[static_cast<size_t>(v) * static_cast<size_t>(image_.stride) + static_cast<size_t>(u)] = grey;
      }
    }
  }

  std::vector<uint8_t> pixels_;
  rvdnav_image image_;
};
