// SPDX-License-Identifier: Zlib
#include "cook/prime_field.h"

#include <algorithm>

namespace limber::prime_field {
namespace {

/// The columns behind `from` in which the row is not zero.
std::vector<std::size_t> nonzeros(const Matrix& m, std::size_t row, std::size_t from) {
  std::vector<std::size_t> columns;
  for (std::size_t c = from; c < m.columns; ++c)
    if (m(row, c) != 0) columns.push_back(c);
  return columns;
}

/// row -= factor * other, in the columns listed from `first` to `last`.
void subtract(Matrix& m, std::size_t row, Element factor, std::size_t other, const std::size_t* first,
              const std::size_t* last) {
  const std::uint64_t minus = kPrime - factor;
  Element* to = &m.entries[row * m.columns];
  const Element* from = &m.entries[other * m.columns];
  for (; first != last; ++first)
    to[*first] = static_cast<Element>((to[*first] + minus * from[*first]) % kPrime);
}

bool mayGoOn(const GoOn& goOn, std::size_t row, std::size_t rows) {
  return !goOn || goOn(static_cast<double>(row) / static_cast<double>(rows));
}

}  // namespace

Element inverse(Element a) {
  // a^(p - 2), Fermat
  Element result = 1, power = a;
  for (std::uint64_t exponent = kPrime - 2; exponent > 0; exponent >>= 1) {
    if (exponent & 1) result = product(result, power);
    power = product(power, power);
  }
  return result;
}

std::size_t rank(Matrix m, const GoOn& goOn) {
  std::size_t found = 0;
  for (std::size_t c = 0; c < m.columns && found < m.rows && mayGoOn(goOn, c, m.columns); ++c) {
    std::size_t pivot = found;
    while (pivot < m.rows && m(pivot, c) == 0) ++pivot;
    if (pivot == m.rows) continue;
    if (pivot != found)
      std::swap_ranges(&m.entries[pivot * m.columns], &m.entries[pivot * m.columns] + m.columns,
                       &m.entries[found * m.columns]);
    const std::vector<std::size_t> columns = nonzeros(m, found, c);
    const Element scale = inverse(m(found, c));
    for (std::size_t r = found + 1; r < m.rows; ++r)
      if (m(r, c) != 0)
        subtract(m, r, product(scale, m(r, c)), found, columns.data(), columns.data() + columns.size());
    ++found;
  }
  return found;
}

std::size_t solveSymmetric(Matrix a, std::vector<Element>& b, const GoOn& goOn) {
  std::vector<std::size_t> pivots;
  for (std::size_t p = 0; p < a.rows && mayGoOn(goOn, p, a.rows); ++p) {
    if (a(p, p) == 0) continue;
    pivots.push_back(p);
    const std::vector<std::size_t> columns = nonzeros(a, p, p + 1);
    const Element scale = inverse(a(p, p));
    const std::size_t* const end = columns.data() + columns.size();
    for (const std::size_t* at = columns.data(); at != end; ++at) {
      const std::size_t r = *at;
      const Element factor = product(scale, a(p, r));
      subtract(a, r, factor, p, at, end);  // all that is read of a row later is what follows its diagonal
      b[r] = difference(b[r], product(factor, b[p]));
    }
  }
  std::vector<Element> x(b.size(), 0);
  for (std::size_t i = pivots.size(); i-- > 0;) {
    const std::size_t p = pivots[i];
    Element rest = b[p];
    for (std::size_t c = p + 1; c < a.columns; ++c)
      if (a(p, c) != 0) rest = difference(rest, product(a(p, c), x[c]));
    x[p] = product(rest, inverse(a(p, p)));
  }
  b = x;
  return pivots.size();
}

}  // namespace limber::prime_field
