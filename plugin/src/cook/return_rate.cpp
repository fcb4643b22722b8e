// SPDX-License-Identifier: Zlib
#include "cook/return_rate.h"

#include "cook/deformations.h"
#include "cook/relaxation.h"

namespace limber {
namespace {

void count(ReturnRate& rate, const RelaxedBody& body, const Points& x) {
  ++rate.runs;
  if (distanceToRest(body, x) < kReturned)
    ++rate.returned;
  else if (distanceToRest(body, -x) < kReturned)
    ++rate.mirrored;
}

}  // namespace

std::uint64_t measuringSeed(std::uint64_t seed) { return seed ^ 0x6d65617375726564u; }  // "measured"

ReturnRate measureReturns(const SpringNetwork& network, Deformation kind, std::uint32_t runs,
                          std::uint64_t seed, const Progress& progress) {
  RelaxedBody body(network);
  ReturnRate rate;
  if (!canRelax(body)) return rate;
  relax(
      body, runs, [&](std::size_t run) { return deform(body.rest, kind, measuringSeed(seed), run); },
      [&](std::size_t, const Points& x) {
        count(rate, body, x);
        return !progress || progress("return rate", static_cast<double>(rate.runs) / runs);
      });
  return rate;
}

}  // namespace limber
