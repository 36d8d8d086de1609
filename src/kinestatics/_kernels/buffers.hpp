// Memory: one growing scratch buffer for each thread, and a pool for large results. A fresh large array costs 2-4 times
// its own computation in page faults; a result the caller has dropped gives its pages to the next one.
#pragma once
#include <cstdlib>
#include <mutex>
#include <new>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace kinestatics {

inline void *allocate_aligned(size_t bytes, size_t alignment) {
  void *p = nullptr;
  return posix_memalign(&p, alignment, bytes) == 0 ? p : nullptr;
}

class Scratch {
 public:
  ~Scratch() { std::free(data_); }
  double *get(size_t doubles) {
    if (doubles > size_) {
      std::free(data_);
      data_ = (double *)allocate_aligned(doubles * sizeof(double), 4096);
      size_ = data_ ? doubles : 0;
    }
    return data_;
  }

 private:
  double *data_ = nullptr;
  size_t size_ = 0;
};

class Pool {
 public:
  static constexpr size_t SMALLEST = 1 << 20, KEPT = 2, LARGEST = size_t(1) << 29;
  // A buffer of at least `bytes`; null when memory is exhausted.
  void *take(size_t bytes, size_t &capacity) {
    {
      std::lock_guard<std::mutex> guard(lock_);
      int best = -1;
      for (size_t i = 0; i < KEPT; i++)
        if (kept_[i].data && kept_[i].bytes >= bytes && kept_[i].bytes <= 2 * bytes &&
            (best < 0 || kept_[i].bytes < kept_[best].bytes))
          best = (int)i;
      if (best >= 0) {
        Slot slot = kept_[best];
        kept_[best] = {};
        capacity = slot.bytes;
        return slot.data;
      }
    }
    const size_t huge = size_t(2) << 20;
    capacity = (bytes + huge - 1) / huge * huge;
    void *data = allocate_aligned(capacity, huge);
#if defined(__linux__)
    if (data) madvise(data, capacity, MADV_HUGEPAGE);
#endif
    return data;
  }
  // Keeps the newest buffers and frees the oldest.
  void give(void *data, size_t bytes) {
    if (bytes > LARGEST) return std::free(data);
    std::lock_guard<std::mutex> guard(lock_);
    for (size_t i = 0; i < KEPT; i++)
      if (!kept_[i].data) {
        kept_[i] = {data, bytes};
        return;
      }
    std::free(kept_[0].data);
    for (size_t i = 1; i < KEPT; i++) kept_[i - 1] = kept_[i];
    kept_[KEPT - 1] = {data, bytes};
  }
  void clear() {
    std::lock_guard<std::mutex> guard(lock_);
    for (Slot &slot : kept_) std::free(slot.data), slot = {};
  }

 private:
  struct Slot {
    void *data;
    size_t bytes;
  };
  std::mutex lock_;
  Slot kept_[KEPT] = {};
};

}  // namespace kinestatics
