// SPDX-License-Identifier: Zlib
#include <limber/network_builder.h>
#include <limber/network_file.h>

#include "cook/file_networks.h"
#include "network/file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

// Contents with a right size and hash but anything else wrong: the hash is no protection against someone who
// makes one, so every such file must be refused with a reason or be a sound network of just these bytes.

namespace limber {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Random = std::mt19937_64;  // its numbers are the same everywhere

/// True if the network was taken.
bool expectRefusedOrSound(const Bytes& bytes) {
  const Result<SharedNetwork> network = fromBytes(bytes.data(), bytes.size());
  if (!network) {
    EXPECT_NE(network.error(), "");
    return false;
  }
  EXPECT_EQ(validate(**network), "");
  EXPECT_EQ(toBytes(**network), bytes);
  return true;
}

std::size_t below(Random& random, std::size_t bound) { return static_cast<std::size_t>(random() % bound); }

std::uint64_t oddCount(Random& random, std::size_t size) {
  const std::uint64_t counts[] = {0, 1, size, size / 24, 0x7fffffff, 0xffffffff, 1ull << 61, ~0ull};
  return counts[below(random, std::size(counts))];
}

void damage(Bytes& bytes, Random& random) {
  const std::size_t at = test::kHeaderBytes + below(random, bytes.size() - test::kHeaderBytes);
  const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
  const auto length = static_cast<std::ptrdiff_t>(
      std::min<std::size_t>(1 + below(random, 24), static_cast<std::size_t>(bytes.end() - place)));
  switch (below(random, 5)) {
    case 0:
      bytes[at] ^= static_cast<std::uint8_t>(1u << below(random, 8));
      break;
    case 1:
      bytes[at] = static_cast<std::uint8_t>(random());
      break;
    case 2:
      if (length >= 8) writeLittleEndian(oddCount(random, bytes.size()), bytes.data() + at);
      break;
    case 3:
      if (bytes.size() > test::kHeaderBytes + 32) bytes.erase(place, place + length);
      break;
    default: {
      const Bytes copy(place, place + length);
      bytes.insert(place, copy.begin(), copy.end());
    }
  }
}

/// How many of `count` damaged files were sound networks.
int fuzz(const SpringNetwork& network, int count, std::uint64_t seed) {
  const Bytes sound = toBytes(network);
  Random random(seed);
  int taken = 0;
  for (int i = 0; i < count; ++i) {
    Bytes bytes = sound;
    for (std::size_t left = 1 + below(random, 4); left > 0; --left) damage(bytes, random);
    taken += expectRefusedOrSound(test::forged(std::move(bytes)));
  }
  return taken;
}

TEST(NetworkFileFuzz, everyChangedByteWithTheRightHash) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  for (std::size_t at = test::kHeaderBytes; at < bytes.size(); ++at) {
    for (unsigned change = 1; change < 256; ++change) {
      Bytes damaged = bytes;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ change);
      expectRefusedOrSound(test::forged(std::move(damaged)));
    }
  }
}

TEST(NetworkFileFuzz, everyTruncationWithTheRightHash) {
  const Bytes bytes = toBytes(test::everyMemberNetwork());
  for (std::size_t size = test::kHeaderBytes; size < bytes.size(); ++size) {
    EXPECT_FALSE(expectRefusedOrSound(
        test::forged(Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)))));
  }
}

TEST(NetworkFileFuzz, thousandsOfMutations) {
  int taken = fuzz(test::everyMemberNetwork(), 20000, 1);
  taken += fuzz(**buildRope(), 5000, 2);
  taken += fuzz(**buildCloth({1.0, 1.0, 3, 3}), 5000, 3);
  EXPECT_GT(taken, 100);  // some changes do no harm: else the fuzzing would stop at the door
  EXPECT_LT(taken, 15000);
}

}  // namespace
}  // namespace limber
