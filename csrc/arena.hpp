// Carves arrays from one block of memory that the caller owns.
#pragma once

#include <stddef.h>
#include <stdint.h>

namespace rvdnav {

// Every array starts on a cache line, so that no two threads share one and vector loads are aligned.
constexpr size_t kAlignment = 64;

constexpr size_t align_up(size_t n) { return (n + kAlignment - 1) / kAlignment * kAlignment; }

// Without a block it only counts: the same layout code answers how much memory is needed and then takes it.
class Arena {
 public:
  Arena() = default;
  // block is aligned to kAlignment.
  Arena(void* block, size_t capacity) : base_(static_cast<unsigned char*>(block)), capacity_(capacity) {}

  template <typename T>
  void take(T** array, size_t count) {
    static_assert(alignof(T) <= kAlignment, "over-aligned type");
    const size_t begin = used_;
    used_ += align_up(count * sizeof(T));
    *array = base_ != nullptr && used_ <= capacity_ ? reinterpret_cast<T*>(base_ + begin) : nullptr;
  }

  size_t used() const { return used_; }
  bool overflowed() const { return base_ != nullptr && used_ > capacity_; }

 private:
  unsigned char* base_ = nullptr;
  size_t capacity_ = 0;
  size_t used_ = 0;
};

}  // namespace rvdnav
