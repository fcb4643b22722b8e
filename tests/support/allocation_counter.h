// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>

namespace limber::test {

/// Counts the allocations of the whole program during the counter's life: through new, malloc (Eigen) and
/// Bullet's allocator. Under a sanitizer, which replaces malloc, counts only those of new and of Bullet's
/// allocator.
class AllocationCounter {
 public:
  AllocationCounter();
  std::size_t allocations() const;

 private:
  std::size_t start_;
};

/// Returns the number of allocations that `work` makes.
template <typename Work>
std::size_t allocationsIn(const Work& work) {
  const AllocationCounter counter;
  work();
  return counter.allocations();
}

}  // namespace limber::test
