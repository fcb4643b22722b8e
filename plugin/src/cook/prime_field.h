// SPDX-License-Identifier: Zlib
#pragma once

#include "core/random.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

/// Arithmetic modulo the prime 2^31 - 1, in which ranks are exact. A matrix of random numbers has a smaller
/// rank than over the reals only where a polynomial in them vanishes by chance (Schwartz 1980).
namespace limber::prime_field {

using Element = std::uint32_t;
constexpr std::uint64_t kPrime = 0x7fffffffu;

inline Element sum(Element a, Element b) { return static_cast<Element>((std::uint64_t(a) + b) % kPrime); }
inline Element difference(Element a, Element b) {
  return static_cast<Element>((std::uint64_t(a) + kPrime - b) % kPrime);
}
inline Element product(Element a, Element b) { return static_cast<Element>(std::uint64_t(a) * b % kPrime); }
Element inverse(Element a);  ///< of a != 0
inline Element random(Random& source) { return static_cast<Element>(source.next() % kPrime); }

struct Matrix {
  std::size_t rows, columns;
  std::vector<Element> entries;  ///< row by row

  Matrix(std::size_t r, std::size_t c) : rows(r), columns(c), entries(r * c, 0) {}
  Element& operator()(std::size_t r, std::size_t c) { return entries[r * columns + c]; }
  Element operator()(std::size_t r, std::size_t c) const { return entries[r * columns + c]; }
};

/// Asked with the share done, 0 to 1, whether to go on; once not, the result means nothing.
using GoOn = std::function<bool(double)>;

std::size_t rank(Matrix matrix, const GoOn& goOn = {});

/// Solves A x = b in place, free unknowns at 0, for a symmetric A whose leading blocks have the ranks of
/// their rows and a b in its range; returns the rank of A. Skips what is zero.
std::size_t solveSymmetric(Matrix a, std::vector<Element>& b, const GoOn& goOn = {});

}  // namespace limber::prime_field
