// SPDX-License-Identifier: Zlib
#include "support/allocation_counter.h"

#include <LinearMath/btAlignedAllocator.h>

#include <atomic>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LIMBER_SANITIZED 1
#else
#define LIMBER_SANITIZED 0
#endif

namespace {

std::atomic<std::size_t> allocationCount{0};

}  // namespace

#if LIMBER_SANITIZED

void* operator new(std::size_t size) {
  ++allocationCount;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocationCount;
  return std::malloc(size);
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

#else

// With glibc, a malloc that the program defines replaces the library's, for new and for all libraries.
extern "C" {
void* __libc_malloc(std::size_t size);
void* malloc(std::size_t size) {
  ++allocationCount;
  return __libc_malloc(size);
}
}

#endif

namespace limber::test {
namespace {

void* countedAlloc(std::size_t size) {
  ++allocationCount;
  return std::malloc(size);
}
void countedFree(void* memory) { std::free(memory); }

}  // namespace

AllocationCounter::AllocationCounter() {
#if LIMBER_SANITIZED
  btAlignedAllocSetCustom(countedAlloc, countedFree);
#else
  (void)countedAlloc;
  (void)countedFree;
#endif
  start_ = allocationCount;
}

std::size_t AllocationCounter::allocations() const { return allocationCount - start_; }

}  // namespace limber::test
