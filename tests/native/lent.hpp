// Memory of a size that the library asked for, with a guard behind it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>

class Lent {
 public:
  explicit Lent(size_t size) : size_(size), memory_(std::aligned_alloc(64, (size + 127) / 64 * 64), &std::free) {
    *guard() = kGuard;
  }
  void* data() const { return memory_.get(); }
  size_t size() const { return size_; }
  bool intact() const { return *guard() == kGuard; }

 private:
  static constexpr uint64_t kGuard = 0x5a5a5a5a5a5a5a5aULL;
  uint64_t* guard() const { return reinterpret_cast<uint64_t*>(static_cast<unsigned char*>(memory_.get()) + size_); }
  size_t size_;
  std::unique_ptr<void, decltype(&std::free)> memory_;
};
