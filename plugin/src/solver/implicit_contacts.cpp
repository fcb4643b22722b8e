// SPDX-License-Identifier: Zlib
// Contacts and anchors in the linear system of an implicit Euler substep.
#include "solver/contact_constraint.h"
#include "solver/implicit_system.h"

#include <Eigen/Geometry>

namespace limber {
namespace {

/// Starts the terms of a contact or anchor: its speeds in three directions, of which the first is the normal.
void beginHeld(ImplicitSystem& s, HeldRows& held) { held.firstTerm = s.heldTerms.size(); }

/// Adds a column with which the speeds change by `rows` times its velocity.
void addHeldTerm(ImplicitSystem& s, Index column, const Matrix3d& rows) {
  s.heldTerms.push_back({static_cast<std::uint32_t>(column), rows});
}

/// Ratio of an anchor's stiffness to that of the springs around it. What it gives way is put back with the
/// masses alone, against the springs.
constexpr double kAnchorStiffness = 100.0;

/// Adds the rows of a contact or anchor. Those of contacts are as stiff as the springs around it: much softer
/// ones would give way, much stiffer ones would slow the iterations down. `load` is the impulse of the last
/// substep (N s), `target` the wanted speeds (m/s), both in the three directions. Without `sticks` the load
/// across the normal stays.
void endHeld(ImplicitSystem& s, HeldRows held, const Vector3d& load, const Vector3d& target) {
  held.endTerm = s.heldTerms.size();
  held.firstRow = s.rows.size();
  held.load = load;
  held.target = target;
  const auto forEachTerm = [&](auto visit) {
    for (std::size_t t = held.firstTerm; t < held.endTerm; ++t)
      visit(s.heldTerms[t].column, s.heldTerms[t].rows);
  };
  for (int k = 0; k < (held.sticks ? 3 : 1); ++k) {
    double mobility = 0.0;
    forEachTerm([&](Index column, const Matrix3d& rows) {
      mobility += rows.row(k) * freeInverse(s, column) * rows.row(k).transpose();
    });
    held.root[k] = mobility > 0.0 ? std::sqrt((held.anchor ? kAnchorStiffness : 1.0) / mobility) : 0.0;
  }
  for (int k = 0; k < 3; ++k) {
    const double root = held.root[k];
    if (root > 0.0) {
      beginRow(s, load[k] / root + root * target[k], true);
      forEachTerm(
          [&](Index column, const Matrix3d& rows) { addTerm(s, column, root * rows.row(k).transpose()); });
    } else if (!held.sticks) {
      forEachTerm([&](Index column, const Matrix3d& rows) {
        s.push.col(column) += load[k] * rows.row(k).transpose();
      });
    }
  }
  s.held.push_back(held);
}

/// Share of the friction cone within which a contact sticks.
constexpr double kSticks = 0.999;

/// Returns the speed (m/s) along the normal at which a contact that had an impulse closes its gap, or removes
/// an overlap.
double heldSpeed(double gap, double maxSpeed, double dt) {
  return std::clamp(-kRecovery * gap / dt, -maxSpeed, maxSpeed);
}

bool sticks(const Vector3d& load, double friction) {
  return load.tail<2>().norm() < kSticks * friction * load[0];
}

Matrix3d axesOf(const Vector3d& normal) {
  Matrix3d rows;
  rows.row(0) = normal;
  rows.row(1) = normal.unitOrthogonal();
  rows.row(2) = normal.cross(Vector3d(rows.row(1)));
  return rows;
}

/// Share of the largest recovery speed: contacts whose gap takes longer to close are not held.
constexpr double kHoldSpeed = 0.1;

constexpr double kSamePlaneCosine = 1.0 - 1e-6;

/// Moves the loads of a point on the tiles of one plane to one of them that it may touch.
void mergeTiles(std::vector<PlaneContact>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].load.isZero(0.0)) continue;
    std::size_t first = i;
    while (first > 0 && rows[first - 1].point == rows[i].point) --first;
    for (std::size_t j = first; j < rows.size() && rows[j].point == rows[i].point && j != i; ++j) {
      if (rows[j].away || !(rows[j].normal.dot(rows[i].normal) > kSamePlaneCosine)) continue;
      rows[j].load += rows[i].load;
      rows[i].load.setZero();
      break;
    }
  }
}

/// Whether the point is held on the same plane already: the tiles of a floor are one surface.
bool isHeldAlready(const ImplicitSystem& s, const PlaneContact& row) {
  for (std::size_t i = s.held.size(); i-- > 0 && s.held[i].plane && s.held[i].plane->point == row.point;)
    if (s.held[i].plane->normal.dot(row.normal) > kSamePlaneCosine) return true;
  return false;
}

void addPlane(ImplicitSystem& s, const Part& part, std::uint32_t body, PlaneContact& row, double time,
              double dt) {
  if (row.coupled) return;
  const Matrix3d axes = axesOf(row.normal);
  const Vector3d load = axes * row.load;
  const Index column = columnOfPoint(s, part, body, row.point);
  const Vector3d x = part.points(body).position.col(row.point);
  const double gap = row.normal.dot(x - row.touch - time * row.surfaceVelocity);
  const double speed = row.normal.dot(s.kicked.col(column) - row.surfaceVelocity);
  const bool near = gap <= dt * std::max(kHoldSpeed * row.recoverySpeed, -speed);
  const bool holds = load[0] > 0.0 && !row.bounces && near;
  const bool closes = speed < minSpeed(gap, row.recoverySpeed, dt) && !(row.restitution > 0.0);
  row.load.setZero();
  if (row.away || !(holds || closes) || isHeldAlready(s, row)) return;
  Vector3d target = axes * row.surfaceVelocity;
  target[0] += holds ? heldSpeed(gap, row.recoverySpeed, dt) : minSpeed(gap, row.recoverySpeed, dt);
  HeldRows held;
  beginHeld(s, held);
  addHeldTerm(s, column, axes);
  held.plane = &row;
  held.friction = row.friction;
  held.sticks = sticks(load, row.friction);
  endHeld(s, held, load, target);
}

/// Adds the columns of one side of a contact, whose points or rotation begin at `point` and `rotation`.
void addSide(ImplicitSystem& s, const Part& part, const ContactConstraint& row, const ContactPoint& side,
             std::uint32_t point, std::uint32_t rotation) {
  const IslandConstraints& pairs = part.group.pairs;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(row.axes[0]);
  if (side.kind == ContactPoint::Kind::Rigid) {
    addHeldTerm(s, columnOfRigid(s, side.body), pairs.points[point].share * axes);
    addHeldTerm(
        s, columnOfRigid(s, side.body) + 1,
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pairs.rotations[rotation].speeds[0]));
  }
  for (std::uint32_t i = 0; side.kind == ContactPoint::Kind::Soft && i < side.count; ++i) {
    Matrix3d rows = pairs.points[point + i].share * axes;
    if (row.couple == Couple::Soft)
      for (int k = 0; k < 2; ++k) rows.row(k + 1) += pairs.momentArms[point + i].across[k] * axes.row(0);
    addHeldTerm(s, columnOfPoint(s, part, side.body, side.point[i]), rows);
  }
}

bool isSoft(const Contact& c) {
  return c.a.kind == ContactPoint::Kind::Soft || c.b.kind == ContactPoint::Kind::Soft;
}

void addPair(ImplicitSystem& s, const Part& part, std::size_t index, double dt) {
  ContactConstraint& row = part.group.pairs.rows[index];
  const Contact& c = part.group.pairs.contacts[index];
  const Vector3d load(row.positionImpulse.n, row.positionImpulse.u, row.positionImpulse.v);
  if (!isSoft(c)) return;
  row.positionImpulse = ContactVector();
  const bool holds = load[0] > 0.0 && !row.bounces;
  const double free = minSpeed(row.gap, c.recoverySpeed, dt);
  const bool closes = !(c.restitution > 0.0) && speedAlong(part.group.pairs, row) < free;
  if (!(row.mass > 0.0) || !(holds || closes)) return;
  HeldRows held;
  beginHeld(s, held);
  addSide(s, part, row, c.a, row.firstPoint, row.firstRotation);
  const bool aIsRigid = c.a.kind == ContactPoint::Kind::Rigid;
  addSide(s, part, row, c.b, row.firstOfB, row.firstRotation + (aIsRigid ? 1 : 0));
  held.pair = &row;
  held.friction = row.friction;
  held.sticks = sticks(load, row.friction);
  endHeld(s, held, load,
          {(holds ? heldSpeed(row.gap, c.recoverySpeed, dt) : free) - row.surfaceSpeeds.n,
           -row.surfaceSpeeds.u, -row.surfaceSpeeds.v});
}

void addAnchor(ImplicitSystem& s, const Part& part, LinkAnchor& anchor, double dt) {
  const RigidState& rigid = part.group.links.rigids[anchor.pivot.body];
  const Vector3d arm = rigid.rotation * anchor.pivot.pivot;
  Matrix3d turn;  // its product with an angular velocity is -(angular velocity) x arm
  turn << 0, -arm.z(), arm.y(), arm.z(), 0, -arm.x(), -arm.y(), arm.x(), 0;
  const Index column = columnOfRigid(s, anchor.pivot.body);
  HeldRows held;
  beginHeld(s, held);
  addHeldTerm(s, columnOfPoint(s, part, anchor.point.body, anchor.point.point), Matrix3d::Identity());
  addHeldTerm(s, column, -Matrix3d::Identity());
  addHeldTerm(s, column + 1, turn);
  held.anchor = &anchor;
  held.sticks = true;
  const Vector3d error =
      endPosition(part.group.links, anchor.point) - endPosition(part.group.links, anchor.pivot);
  endHeld(s, held, anchor.positionImpulse, (anchor.apart - error) / dt);
  anchor.positionImpulse.setZero();
}

}  // namespace

void addHolds(ImplicitSystem& s, const Part& part, double time, double dt) {
  for (std::size_t i = part.begin; i < part.end; ++i) {
    SolverBody& body = part.group.bodies[i];
    const auto number = static_cast<std::uint32_t>(i);
    if (body.contacts) mergeTiles(*body.contacts);
    if (body.contacts)
      for (PlaneContact& row : *body.contacts) addPlane(s, part, number, row, time, dt);
    if (body.watch)
      for (PlaneContact& row : body.watch->rows) addPlane(s, part, number, row, time, dt);
  }
  if (!part.together) return;
  for (std::size_t i = 0; i < part.group.pairs.rows.size(); ++i) addPair(s, part, i, dt);
  for (LinkAnchor& anchor : part.group.links.anchors) addAnchor(s, part, anchor, dt);
}

namespace {

/// Returns the impulse of which a contact is capable: it does not pull, and friction stays in its cone.
Vector3d possibleLoad(const HeldRows& held, Vector3d load) {
  if (held.anchor) return load;
  if (!(load[0] > 0.0)) return Vector3d::Zero();
  load.tail<2>() *= coneFactor(load.tail<2>().squaredNorm(), held.friction * load[0]);
  return load;
}

/// Returns the impulse with which the next substep begins: that of a sliding contact is against the sliding
/// (m/s), and becomes smaller where that has reversed.
Vector3d nextLoad(const HeldRows& held, const Vector3d& load, const Vector3d& slip) {
  if (held.sticks) return load;
  Vector3d next = load;
  if (slip.tail<2>().dot(load.tail<2>()) < 0.0 || load.tail<2>().isZero(0.0))
    next.tail<2>() = -held.friction * load[0] * slip.tail<2>().stableNormalized();
  else
    next.tail<2>() *= 0.5;
  return next;
}

void storeLoads(const HeldRows& held, const Vector3d& load, const Vector3d& next) {
  if (held.anchor) {
    held.anchor->positionImpulse = next;
  } else if (held.pair) {
    held.pair->positionImpulse = {next[0], next[1], next[2]};
    held.pair->impulse += {load[0], load[1], load[2]};
  } else {
    const Matrix3d axes = axesOf(held.plane->normal);
    held.plane->load = axes.transpose() * next;
    held.plane->impulse.add(axes.transpose() * load, held.plane->normal, load[0]);
  }
}

}  // namespace

void finishHolds(ImplicitSystem& s) {
  s.push.setZero();
  for (const HeldRows& held : s.held) {
    Vector3d load = held.load, slip = -held.target;
    std::size_t r = held.firstRow;
    for (int k = 0; k < 3; ++k) {
      if (!(held.root[k] > 0.0)) continue;
      load[k] = held.root[k] * impulseOf(s, s.rows[r], s.start);
      s.rows[r++].external = false;
    }
    load = possibleLoad(held, load);
    for (std::size_t t = held.firstTerm; t < held.endTerm; ++t) {
      const HeldTerm& term = s.heldTerms[t];
      slip += term.rows * s.start.col(term.column);
      s.push.col(term.column) += term.rows.transpose() * load;
    }
    storeLoads(held, load, nextLoad(held, load, slip));
  }
  for (StiffRow& row : s.rows) {
    if (row.external) apply(s, row, impulseOf(s, row, s.start), s.push);
    row.external = false;
  }
}

void dropHolds(ImplicitSystem& s) {
  for (const HeldRows& held : s.held) storeLoads(held, Vector3d::Zero(), Vector3d::Zero());
  s.push.setZero();
}

void takeOutLoads(ImplicitSystem& system, SolverIsland& group) {
  for (SolverBody& body : group.bodies)
    for (std::vector<PlaneContact>* rows : {body.contacts, body.watch ? &body.watch->rows : nullptr})
      for (std::size_t i = 0; rows && i < rows->size(); ++i) (*rows)[i].load -= (*rows)[i].impulse.sum;
  system.loads.clear();
  for (std::size_t i = 0; i < group.pairs.rows.size(); ++i) {
    ContactVector& impulse = group.pairs.rows[i].positionImpulse;
    system.loads.push_back({impulse.n, impulse.u, impulse.v});
    if (isSoft(group.pairs.contacts[i])) impulse = ContactVector();
  }
  for (LinkAnchor& anchor : group.links.anchors) {
    system.loads.push_back(anchor.positionImpulse);
    anchor.positionImpulse.setZero();
  }
}

void putBackLoads(ImplicitSystem& system, SolverIsland& group) {
  for (SolverBody& body : group.bodies)
    for (std::vector<PlaneContact>* rows : {body.contacts, body.watch ? &body.watch->rows : nullptr})
      for (std::size_t i = 0; rows && i < rows->size(); ++i) (*rows)[i].load += (*rows)[i].impulse.sum;
  std::size_t next = 0;
  for (std::size_t i = 0; i < group.pairs.rows.size(); ++i, ++next)
    if (isSoft(group.pairs.contacts[i])) {
      const Vector3d& load = system.loads[next];
      group.pairs.rows[i].positionImpulse += {load[0], load[1], load[2]};
    }
  for (LinkAnchor& anchor : group.links.anchors) anchor.positionImpulse += system.loads[next++];
}

}  // namespace limber
