// SPDX-License-Identifier: Zlib
#pragma once

#include "collide/moving_surface.h"
#include "solver/closest_points.h"

#include <algorithm>
#include <limits>

namespace limber {

/// Nearest places on two features at one time.
template <int N, int M>
struct NearestPlaces {
  Eigen::Matrix<double, N, 1> a;  ///< weights of the corners
  Eigen::Matrix<double, M, 1> b;
  Eigen::Vector3d away = Eigen::Vector3d::Zero();  ///< m, from b to a
  double distance = 0.0;                           ///< m
  double time = 0.0;                               ///< share of the tick
};

inline void nearestWeights(const MovingFeature<1>::Corners&, const MovingFeature<1>::Corners&,
                           NearestPlaces<1, 1>& places) {
  places.a[0] = places.b[0] = 1.0;
}

inline void nearestWeights(const MovingFeature<1>::Corners& a, const MovingFeature<2>::Corners& b,
                           NearestPlaces<1, 2>& places) {
  const double along = nearestOnSegment(b.col(0), b.col(1), a.col(0));
  places.a[0] = 1.0;
  places.b << 1.0 - along, along;
}

inline void nearestWeights(const MovingFeature<2>::Corners& a, const MovingFeature<2>::Corners& b,
                           NearestPlaces<2, 2>& places) {
  const SegmentPair along = nearestOnSegments(a.col(0), a.col(1), b.col(0), b.col(1));
  places.a << 1.0 - along.a, along.a;
  places.b << 1.0 - along.b, along.b;
}

template <int N, int M>
NearestPlaces<N, M> nearestPlaces(const MovingFeature<N>& a, const MovingFeature<M>& b, double time) {
  const auto atA = a.at(time);
  const auto atB = b.at(time);
  NearestPlaces<N, M> places;
  nearestWeights(atA, atB, places);
  places.away = atA * places.a - atB * places.b;
  places.distance = places.away.norm();
  places.time = time;
  return places;
}

/// m over the tick: how much the distance of the features along the unit `direction` from b to a can shrink.
template <int N, int M>
double approachAlong(const Eigen::Vector3d& direction, const MovingFeature<N>& a, const MovingFeature<M>& b) {
  return (direction.transpose() * b.motion).maxCoeff() - (direction.transpose() * a.motion).minCoeff();
}

/// Steps to a meeting; features that turn past each other need most.
constexpr int kMostAdvances = 32;
/// Share of the margin within which features have met.
constexpr double kMetShare = 0.01;
/// Later than the tick.
constexpr double kNever = std::numeric_limits<double>::infinity();

/// When the features come within `reach` (m) of each other: conservative advancement (Mirtich 1996), each
/// step along the direction between the nearest places, which bounds the approach of all others. A direct
/// hit takes one step.
/// @returns where they meet; or, if they do not within the tick but start within `margin` more, where they
/// are nearest at its start; else a time of kNever.
template <int N, int M>
NearestPlaces<N, M> findMeeting(const MovingFeature<N>& a, const MovingFeature<M>& b, double reach,
                                double margin) {
  const NearestPlaces<N, M> start = nearestPlaces(a, b, 0.0);
  NearestPlaces<N, M> places = start;
  for (int i = 0; i < kMostAdvances; ++i) {
    const double gap = places.distance - reach;
    if (gap <= kMetShare * margin) return places;
    const double approach = approachAlong(places.away / places.distance, a, b);
    const double time = approach > 0.0 ? places.time + gap / approach : kNever;
    if (time > 1.0) break;
    places = nearestPlaces(a, b, time);
  }
  places = start;
  if (start.distance - reach > margin) places.time = kNever;
  return places;
}

}  // namespace limber
