// SPDX-License-Identifier: Zlib
// Orders the springs and tetrahedra of a body and divides them among threads.
#include "solver/springs.h"

#include <numeric>

namespace limber {
namespace {

// --- the order of springs ----------------------------------------------------------------------------------

/// Number of springs among which a suitable one is searched. The limit keeps the time linear in their number,
/// and the springs of a batch near each other in memory.
constexpr std::size_t kWindow = 256;

/// Number of springs, or of batches in strips, after which a point or slot may come again at no cost. A
/// damper waits for the velocities that the one before it at the same point writes, some 50 cycles. Meanwhile
/// a processor computes the next batches, as many as fit into the 200 to 500 instructions that it looks
/// ahead. Networks with less than four times as many points have no springs that are so far apart: for them
/// only the springs of a batch matter.
constexpr std::size_t kFarApart = 24, kBatchesApart = 6;

/// Returns an order of these springs as divideSprings() requires it. Springs that are near each other in the
/// given order stay near each other.
std::vector<std::uint32_t> orderApart(const SpringNetwork& network, std::size_t farApart,
                                      std::vector<std::uint32_t> left) {
  const std::size_t enough = network.restPoints.size() < 4 * farApart ? 1 : farApart;
  // #points: 1 + place in the order of the last spring with this point, or 0
  std::vector<std::size_t> used(network.restPoints.size(), 0);
  for (std::size_t next = 0; next < left.size(); ++next) {
    // the number of springs since the last one that shares a point with this one, at most `enough`;
    // 0 if that one is in the present batch: then the dampers of the batch are computed one by one
    const auto distanceOf = [&](const NetworkSpring& spring) {
      const std::size_t last = std::max(used[spring.a], used[spring.b]);
      if (last == 0) return enough;
      return last > next / 4 * 4 ? 0 : std::min(next + 1 - last, enough);
    };
    const std::size_t end = std::min(left.size(), next + kWindow);
    std::size_t best = next, farthest = 0;
    for (std::size_t k = next; k < end && farthest < enough; ++k)
      if (const std::size_t distance = distanceOf(network.springs[left[k]]); distance > farthest)
        best = k, farthest = distance;
    // moves the skipped springs up by one, in the same order
    const auto begin = left.begin() + static_cast<std::ptrdiff_t>(next);
    const auto chosen = left.begin() + static_cast<std::ptrdiff_t>(best);
    std::rotate(begin, chosen, chosen + 1);
    used[network.springs[left[next]].a] = used[network.springs[left[next]].b] = next + 1;
  }
  return left;
}

// --- the division ------------------------------------------------------------------------------------------

/// Springs or tetrahedra of a slab: with fewer, threads would wait for each other as long as they work, and
/// springs that share a point would be nearer to each other.
constexpr std::size_t kSlabElements = 1500;

/// Slabs that keep eight threads busy. More would have more springs between them, whose points are visited
/// twice.
constexpr std::size_t kMaxSlabs = 8;

/// Largest share of the elements that a thread computes if each range has a thread.
constexpr double kLongestPath = 0.6;

/// The points of a body in slabs, with about as many points each.
struct PointSlabs {
  std::vector<std::uint32_t> slabOf;  ///< #points
  std::vector<std::uint32_t> order;   ///< points by slab, then by number
  std::vector<Range> ranges;          ///< #slabs, of `order`
};

/// Returns the axis along which the body is divided: a long one, so that few springs cross a cut, and of
/// several nearly equal ones that along which the numbers of points grow. The points of a slab are then near
/// each other in memory, too.
Eigen::Index axisOf(const std::vector<Eigen::Vector3d>& x) {
  constexpr double kNearlyAsLong = 0.8;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : x) box.extend(p);
  Eigen::Vector3d path = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i < x.size(); ++i) path += (x[i] - x[i - 1]).cwiseAbs();
  Eigen::Index best;
  const double longest = box.sizes().maxCoeff(&best);
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (box.sizes()[axis] > kNearlyAsLong * longest && path[axis] < path[best]) best = axis;
  return best;
}

/// Divides the points across an axis. Points of one layer of a lattice, which are equally far along, stay
/// together.
PointSlabs slabsOf(const std::vector<Eigen::Vector3d>& x, std::size_t slabs) {
  const Eigen::Index axis = axisOf(x);
  const auto isBefore = [&](std::uint32_t i, std::uint32_t j) {
    return x[i][axis] != x[j][axis] ? x[i][axis] < x[j][axis] : i < j;
  };
  PointSlabs result;
  std::vector<std::uint32_t>& order = result.order;
  order.resize(x.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), isBefore);
  result.slabOf.resize(x.size());
  const double same = 1e-6 * (x[order.back()][axis] - x[order.front()][axis]);
  std::uint32_t begin = 0;
  for (std::uint32_t k = 0; k < order.size(); ++k) {
    const bool isFull = k >= (result.ranges.size() + 1) * order.size() / slabs;
    if (isFull && x[order[k]][axis] - x[order[k - 1]][axis] > same)
      result.ranges.push_back({begin, k}), begin = k;
    result.slabOf[order[k]] = static_cast<std::uint32_t>(result.ranges.size());
  }
  result.ranges.push_back({begin, static_cast<std::uint32_t>(order.size())});
  for (const Range& range : result.ranges) std::sort(order.data() + range.begin, order.data() + range.end);
  return result;
}

/// Divides elements with N corners: those inside one slab; those across one cut between neighbouring slabs;
/// and the others: those that span more, or share a point with elements across another cut.
template <std::size_t N>
struct Slabs {
  std::vector<std::vector<std::uint32_t>> inside, across;
  std::vector<std::uint32_t> others;

  template <class Corners>
  Slabs(const PointSlabs& points, std::size_t elements, Corners cornersOf)
      : inside(points.ranges.size()), across(points.ranges.size() - 1) {
    const std::vector<std::uint32_t>& slabOf = points.slabOf;
    constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
    std::vector<std::uint32_t> cutOf(slabOf.size(), kNone);
    for (std::uint32_t i = 0; i < elements; ++i) {
      const std::array<std::uint32_t, N> corners = cornersOf(i);
      std::uint32_t low = kNone, high = 0;
      for (const std::uint32_t corner : corners)
        low = std::min(low, slabOf[corner]), high = std::max(high, slabOf[corner]);
      const auto isFree = [&](std::uint32_t corner) {
        return cutOf[corner] == kNone || cutOf[corner] == low;
      };
      if (low == high) {
        inside[low].push_back(i);
      } else if (high == low + 1 && std::all_of(corners.begin(), corners.end(), isFree)) {
        across[low].push_back(i);
        for (const std::uint32_t corner : corners) cutOf[corner] = low;
      } else {
        others.push_back(i);
      }
    }
  }
};

/// Moves the last one to three of them to `others`, so that ranges consist of whole batches.
void keepWholeBatches(std::vector<std::uint32_t>& elements, std::vector<std::uint32_t>& others) {
  const auto whole = elements.begin() + static_cast<std::ptrdiff_t>(elements.size() / 4 * 4);
  others.insert(others.end(), whole, elements.end());
  elements.erase(whole, elements.end());
}

/// Appends a range, which may be empty.
void append(const std::vector<std::uint32_t>& elements, std::size_t phase, Division& division) {
  const auto begin = static_cast<std::uint32_t>(division.order.size());
  division.order.insert(division.order.end(), elements.begin(), elements.end());
  division.phases[phase].push_back({begin, static_cast<std::uint32_t>(division.order.size())});
}

std::size_t largest(const std::vector<std::vector<std::uint32_t>>& ranges) {
  std::size_t size = 0;
  for (const std::vector<std::uint32_t>& range : ranges) size = std::max(size, range.size());
  return size;
}

/// `arrange` returns the order of the elements of a range, `weight` is the number of springs or tetrahedra in
/// an element.
template <std::size_t N, class Corners, class Arrange>
Division divide(const SpringNetwork& network, std::size_t elements, std::size_t weight, Corners cornersOf,
                Arrange arrange) {
  Division division;
  for (std::size_t count = kMaxSlabs; count > 1; count /= 2) {
    if (elements * weight < count * kSlabElements) continue;
    PointSlabs points = slabsOf(network.restPoints, count);
    Slabs<N> slabs(points, elements, cornersOf);
    for (auto* ranges : {&slabs.inside, &slabs.across})
      for (std::vector<std::uint32_t>& range : *ranges) keepWholeBatches(range, slabs.others);
    const std::size_t path = largest(slabs.inside) + largest(slabs.across) + slabs.others.size();
    if (double(path) > kLongestPath * double(elements)) continue;
    for (const auto& range : slabs.inside) append(arrange(range), 0, division);
    for (const auto& range : slabs.across) append(arrange(range), 1, division);
    append(arrange(slabs.others), 2, division);
    division.points = std::move(points.order);
    division.pointRanges = std::move(points.ranges);
    return division;
  }
  std::vector<std::uint32_t> all(elements);
  std::iota(all.begin(), all.end(), 0u);
  append(arrange(all), 0, division);
  return division;
}

Division divideNetwork(const SpringNetwork& network, std::size_t weight, std::size_t farApart) {
  const auto cornersOf = [&](std::uint32_t i) {
    return std::array<std::uint32_t, 2>{network.springs[i].a, network.springs[i].b};
  };
  const auto arrange = [&](std::vector<std::uint32_t> range) {
    return orderApart(network, farApart, std::move(range));
  };
  return divide<2>(network, network.springs.size(), weight, cornersOf, arrange);
}

// --- strips ------------------------------------------------------------------------------------------------

/// A regular network has few differences between the numbers of a spring's ends: a lattice with springs
/// between all neighbours has 13, a cloth 6.
constexpr std::size_t kMostDifferences = 32;

/// Smallest share of a batch that has springs, on average, and largest length of strips relative to the
/// least. A batch in strips takes less than half the time of another one.
constexpr double kLeastFill = 0.7;
constexpr std::uint32_t kLongest = 2;

/// A spring from the point with the lower number to the one with the higher number.
struct Step {
  std::uint32_t from, difference;
};

/// The springs of a network as steps, and their distinct differences in ascending order.
struct Steps {
  std::vector<Step> steps;
  std::vector<std::uint32_t> differences;

  explicit Steps(const SpringNetwork& network) {
    for (const NetworkSpring& spring : network.springs) {
      const std::uint32_t low = std::min(spring.a, spring.b), difference = std::max(spring.a, spring.b) - low;
      steps.push_back({low, difference});
      const auto at = std::lower_bound(differences.begin(), differences.end(), difference);
      if (at != differences.end() && *at == difference) continue;
      differences.insert(at, difference);
      if (differences.size() > kMostDifferences) return;
    }
  }
  bool isRegular() const {
    return !differences.empty() && differences.front() > 0 && differences.size() <= kMostDifferences;
  }
};

/// The batches of springs in strips of one length, and the springs of each, by strip.
struct StripBatches {
  static constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
  std::uint32_t length;
  std::vector<Strips::Batch> batches;
  std::vector<std::array<std::uint32_t, Strips::kCount>> springs;  // #batches; kNone: missing

  StripBatches(const Steps& network, std::uint32_t slots) : length(slots) {
    const std::vector<std::uint32_t>& differences = network.differences;
    std::vector<std::uint32_t> batchOf(slots * differences.size(), kNone);
    for (std::uint32_t i = 0; i < network.steps.size(); ++i) {
      const Step& step = network.steps[i];
      const auto at = std::lower_bound(differences.begin(), differences.end(), step.difference);
      const std::uint32_t slot = step.from % slots, strip = step.from / slots;
      std::uint32_t& batch = batchOf[slot * differences.size() + std::size_t(at - differences.begin())];
      if (batch == kNone || springs[batch][strip] != kNone) {
        batch = static_cast<std::uint32_t>(batches.size());
        const std::uint32_t end = slot + step.difference;
        batches.push_back({slot, end % slots, end / slots});
        springs.push_back({kNone, kNone, kNone, kNone});
      }
      springs[batch][strip] = i;
    }
  }
};

/// Returns the batches in strips of that length for which there are the fewest; none if the network is not
/// regular enough. In a grid of rows this is a multiple of their length, so that no row is cut.
StripBatches stripBatches(const SpringNetwork& network) {
  const Steps steps(network);
  StripBatches best(Steps(SpringNetwork()), 0);
  if (!steps.isRegular()) return best;
  const std::uint32_t least = (static_cast<std::uint32_t>(network.restPoints.size()) + 3) / Strips::kCount;
  for (const std::uint32_t difference : steps.differences) {
    const std::uint32_t length = (least + difference - 1) / difference * difference;
    if (length <= steps.differences.back() || length > kLongest * least) continue;
    StripBatches tried(steps, length);
    if (best.length == 0 || tried.batches.size() < best.batches.size()) best = std::move(tried);
  }
  if (double(network.springs.size()) < kLeastFill * Strips::kCount * double(best.batches.size()))
    best.length = 0;
  return best;
}

/// Sorts the batches by their first slot: their ends are then near each other in memory.
void sortBySlot(StripBatches& strips) {
  std::vector<std::uint32_t> order(strips.batches.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return strips.batches[i].a < strips.batches[j].a;
  });
  StripBatches sorted = strips;
  for (std::size_t k = 0; k < order.size(); ++k)
    sorted.batches[k] = strips.batches[order[k]], sorted.springs[k] = strips.springs[order[k]];
  strips = std::move(sorted);
}

/// Returns a network whose points are slots and whose springs are batches.
SpringNetwork slotNetwork(const SpringNetwork& network, const StripBatches& strips) {
  SpringNetwork slots;
  slots.restPoints.assign(network.restPoints.begin(), network.restPoints.begin() + strips.length);
  for (const Strips::Batch& batch : strips.batches)
    slots.springs.push_back({batch.a, batch.b, SpringKind::Structural, 1.0});
  return slots;
}

/// Returns the points of slots in ascending order.
std::vector<std::uint32_t> pointsOf(const std::uint32_t* slots, std::size_t count, std::uint32_t length,
                                    std::size_t points) {
  std::vector<std::uint32_t> result;
  for (std::uint32_t first = 0; first < Strips::kCount * length; first += length)
    for (std::size_t k = 0; k < count; ++k)
      if (first + slots[k] < points) result.push_back(first + slots[k]);
  return result;
}

/// Makes the division of springs out of that of their batches.
Division springsOf(Division batches, const StripBatches& made, std::size_t points) {
  Division division;
  division.strips.length = made.length;
  std::vector<std::uint32_t> firsts;  // of the springs of each batch
  for (const std::uint32_t i : batches.order) {
    firsts.push_back(static_cast<std::uint32_t>(division.order.size()));
    const auto batch = static_cast<std::uint32_t>(division.strips.batches.size());
    division.strips.batches.push_back(made.batches[i]);
    for (std::uint32_t strip = 0; strip < Strips::kCount; ++strip) {
      if (made.springs[i][strip] == StripBatches::kNone) continue;
      division.order.push_back(made.springs[i][strip]);
      division.strips.places.push_back(Strips::kCount * batch + strip);
    }
  }
  firsts.push_back(static_cast<std::uint32_t>(division.order.size()));
  for (std::size_t phase = 0; phase < Division::kPhases; ++phase)
    for (const Range& range : batches.phases[phase])
      division.phases[phase].push_back({firsts[range.begin], firsts[range.end]});
  for (const Range& range : batches.pointRanges) {
    const auto begin = static_cast<std::uint32_t>(division.points.size());
    const std::vector<std::uint32_t> slab =
        pointsOf(batches.points.data() + range.begin, range.end - range.begin, made.length, points);
    division.points.insert(division.points.end(), slab.begin(), slab.end());
    division.pointRanges.push_back({begin, static_cast<std::uint32_t>(division.points.size())});
  }
  division.slots = std::move(batches.points);
  division.slotRanges = std::move(batches.pointRanges);
  return division;
}

}  // namespace

Division divideSprings(const SpringNetwork& network) {
  StripBatches strips = stripBatches(network);
  if (strips.length == 0) return divideNetwork(network, 1, kFarApart);
  sortBySlot(strips);
  return springsOf(divideNetwork(slotNetwork(network, strips), Strips::kCount, kBatchesApart), strips,
                   network.restPoints.size());
}

Division divideTetrahedra(const SpringNetwork& network) {
  const auto cornersOf = [&](std::uint32_t i) { return network.tetrahedra[i]; };
  return divide<4>(network, network.tetrahedra.size(), 1, cornersOf,
                   [](const std::vector<std::uint32_t>& range) { return range; });
}

}  // namespace limber
