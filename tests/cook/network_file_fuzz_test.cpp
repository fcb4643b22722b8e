// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>
#include <limber/spring_network.h>

#include "cook/file_networks.h"
#include "mesh/bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

// Files with the correct size and hash but damaged contents. The hash does not protect against forged files,
// so each must be refused with a reason, or give a valid network of exactly these bytes.

namespace limber {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Random = std::mt19937_64;  // its numbers are the same everywhere

/// Returns whether the network was accepted.
bool expectRefusedOrValid(const Bytes& bytes) {
  const Result<SharedNetwork> network = fromBytes(bytes.data(), bytes.size());
  if (!network) {
    EXPECT_NE(network.error(), "");
    return false;
  }
  EXPECT_EQ(validate(**network).error(), "");
  EXPECT_EQ(toBytes(**network), bytes);
  return true;
}

std::size_t below(Random& random, std::size_t bound) { return static_cast<std::size_t>(random() % bound); }

std::uint64_t unusualCount(Random& random, std::size_t size) {
  const std::uint64_t counts[] = {0, 1, size, size / 24, 0x7fffffff, 0xffffffff, 1ull << 61, ~0ull};
  return counts[below(random, std::size(counts))];
}

void damage(Bytes& bytes, Random& random) {
  const std::size_t index = test::kHeaderBytes + below(random, bytes.size() - test::kHeaderBytes);
  const auto position = bytes.begin() + static_cast<std::ptrdiff_t>(index);
  const auto length = static_cast<std::ptrdiff_t>(
      std::min<std::size_t>(1 + below(random, 24), static_cast<std::size_t>(bytes.end() - position)));
  switch (below(random, 5)) {
    case 0:
      bytes[index] ^= static_cast<std::uint8_t>(1u << below(random, 8));
      break;
    case 1:
      bytes[index] = static_cast<std::uint8_t>(random());
      break;
    case 2:
      if (length >= 8) writeLittleEndian(unusualCount(random, bytes.size()), bytes.data() + index);
      break;
    case 3:
      if (bytes.size() > test::kHeaderBytes + 32) bytes.erase(position, position + length);
      break;
    default: {
      const Bytes copy(position, position + length);
      bytes.insert(position, copy.begin(), copy.end());
    }
  }
}

/// Returns how many of `count` damaged files gave a valid network.
int fuzz(const SpringNetwork& network, int count, std::uint64_t seed) {
  const Bytes validBytes = toBytes(network);
  Random random(seed);
  int accepted = 0;
  for (int i = 0; i < count; ++i) {
    Bytes bytes = validBytes;
    for (std::size_t changes = 1 + below(random, 4); changes > 0; --changes) damage(bytes, random);
    accepted += expectRefusedOrValid(test::forged(std::move(bytes)));
  }
  return accepted;
}

TEST(NetworkFileFuzz, everyChangedByteWithTheRightHash) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  for (std::size_t at = test::kHeaderBytes; at < bytes.size(); ++at) {
    for (unsigned change = 1; change < 256; ++change) {
      Bytes damaged = bytes;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ change);
      expectRefusedOrValid(test::forged(std::move(damaged)));
    }
  }
}

TEST(NetworkFileFuzz, everyTruncationWithTheRightHash) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  for (std::size_t size = test::kHeaderBytes; size < bytes.size(); ++size) {
    EXPECT_FALSE(expectRefusedOrValid(
        test::forged(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)))));
  }
}

TEST(NetworkFileFuzz, thousandsOfMutations) {
  int accepted = fuzz(test::everyMemberNetwork(), 20000, 1);
  accepted += fuzz(**buildRope(), 5000, 2);
  accepted += fuzz(**buildCloth({1.0, 1.0, 3, 3}), 5000, 3);
  EXPECT_GT(accepted, 100);  // some changes are valid; otherwise only the first checks would be tested
  EXPECT_LT(accepted, 15000);
}

}  // namespace
}  // namespace limber
