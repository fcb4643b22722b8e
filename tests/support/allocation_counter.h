// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

namespace limber::test {

/// Counts what the whole program allocates during its life, through new, malloc (Eigen) and Bullet's
/// allocator. Under a sanitizer, which owns malloc, new and Bullet's allocator alone are counted.
class AllocationCounter {
 public:
  AllocationCounter();
  std::size_t allocations() const;

 private:
  std::size_t start_;
};

}  // namespace limber::test
