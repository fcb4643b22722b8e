// SPDX-License-Identifier: Zlib
// The code of spring_kernel_*.cpp. Before it they define, in limber::kernel: Quad, four doubles, with its
// arithmetic, and Rows and the functions that move numbers within Quads.

// Loops over springs, tetrahedra and triangles work on a copy of the body: nothing else refers to it, so its
// pointers stay in registers.

namespace limber::kernel {
namespace {

Quad* quads(double* numbers) { return reinterpret_cast<Quad*>(numbers); }
const Quad* quads(const double* numbers) { return reinterpret_cast<const Quad*>(numbers); }

void pullTogether(const SpringBatchBody& b, Index spring, Quad pull, Quad direction) {
  const Quad force = pull * direction;
  Quad& fa = quads(b.points.force)[b.springs.a[spring]];
  fa = fa + force;
  Quad& fb = quads(b.points.force)[b.springs.b[spring]];
  fb = fb - force;
}

/// Keeps the stretch of four springs, the i-th batch. Returns their forces, with a share of crossingForce().
Quad crossedForce(const SpringBatchBody& b, Index i, const Pull<Quad>& pull, double share) {
  Quad& stretch = quads(b.springs.stretch)[i];
  const Quad difference = quads(b.springs.extensionStiffness)[i] - quads(b.springs.compressionStiffness)[i];
  const Quad force = pull.force + all(Quad(), share) * crossingForce(stretch, pull.stretch, difference,
                                                                     quads(b.springs.crossingLoss)[i]);
  stretch = pull.stretch;
  return force;
}

/// Does the same as addForce() of verlet_kernel.h for four springs, from i on.
void addForces(const SpringBatchBody& b, Index i, double crossing) {
  const Quad* x = quads(b.points.position);
  const Quad d0 = x[b.springs.b[i]] - x[b.springs.a[i]], d1 = x[b.springs.b[i + 1]] - x[b.springs.a[i + 1]];
  const Quad d2 = x[b.springs.b[i + 2]] - x[b.springs.a[i + 2]],
             d3 = x[b.springs.b[i + 3]] - x[b.springs.a[i + 3]];
  const Vector<Quad> d = columns(d0, d1, d2, d3);
  const Pull<Quad> p =
      pullOf(dot(d, d), quads(b.springs.restLength)[i / 4], quads(b.springs.extensionStiffness)[i / 4],
             quads(b.springs.compressionStiffness)[i / 4]);
  quads(b.springs.direction)[i / 4] = p.scale;
  const Quad force = b.springs.stretch ? crossedForce(b, i / 4, p, crossing) : p.force;
  const Quad scale = b.springs.stretch ? p.inverse : p.scale;
  pullTogether(b, i, spread<0>(force), d0 * spread<0>(scale));
  pullTogether(b, i + 1, spread<1>(force), d1 * spread<1>(scale));
  pullTogether(b, i + 2, spread<2>(force), d2 * spread<2>(scale));
  pullTogether(b, i + 3, spread<3>(force), d3 * spread<3>(scale));
}

/// Returns the direction of one of four springs, as addForces() computes it. Only the inverse length is
/// stored, which needs a quarter of the memory: large bodies are limited by memory bandwidth.
template <int i>
Quad directionOf(const SpringBatchBody& b, Index first, Quad inverseLength) {
  const Quad* x = quads(b.points.position);
  return (x[b.springs.b[first + i]] - x[b.springs.a[first + i]]) * spread<i>(inverseLength);
}

void push(const SpringBatchBody& b, Index spring, Quad impulse, Quad direction) {
  const Quad j = impulse * direction;
  const Index ia = b.springs.a[spring], ib = b.springs.b[spring];
  Quad* v = quads(b.points.velocity);
  const Quad* w = quads(b.points.inverseMass);
  v[ia] = v[ia] + j * w[ia];
  v[ib] = v[ib] - j * w[ib];
}

Quad closing(const SpringBatchBody& b, Index spring, Quad direction) {
  const Quad* v = quads(b.points.velocity);
  return direction * (v[b.springs.b[spring]] - v[b.springs.a[spring]]);
}

/// Does the same as damp() of verlet_kernel.h for four springs that share no point.
void dampTogether(const SpringBatchBody& b, Index i, Quad factor) {
  const Quad scale = quads(b.springs.direction)[i / 4];
  const Quad n0 = directionOf<0>(b, i, scale), n1 = directionOf<1>(b, i, scale);
  const Quad n2 = directionOf<2>(b, i, scale), n3 = directionOf<3>(b, i, scale);
  const Vector<Quad> c =
      columns(closing(b, i, n0), closing(b, i + 1, n1), closing(b, i + 2, n2), closing(b, i + 3, n3));
  const Quad impulse = factor * (c.x + (c.y + c.z));
  push(b, i, spread<0>(impulse), n0);
  push(b, i + 1, spread<1>(impulse), n1);
  push(b, i + 2, spread<2>(impulse), n2);
  push(b, i + 3, spread<3>(impulse), n3);
}

/// Applies one damper of a batch in which springs share points.
template <int i>
void dampOne(const SpringBatchBody& b, Index first, Quad factor) {
  const Quad n = directionOf<i>(b, first, quads(b.springs.direction)[first / 4]);
  const Quad c = closing(b, first + i, n);
  push(b, first + i, spread<i>(factor) * all(Quad(), total(c)), n);
}

void dampInTurn(const SpringBatchBody& b, Index i, Quad factor, bool forward) {
  if (forward) {
    dampOne<0>(b, i, factor), dampOne<1>(b, i, factor), dampOne<2>(b, i, factor), dampOne<3>(b, i, factor);
  } else {
    dampOne<3>(b, i, factor), dampOne<2>(b, i, factor), dampOne<1>(b, i, factor), dampOne<0>(b, i, factor);
  }
}

// --- springs in strips ---

/// Returns a quantity of a slot.
Vector<Quad> of(const double* slot, Index quantity) {
  return {fourAt(slot + quantity), fourAt(slot + quantity + 4), fourAt(slot + quantity + 8)};
}

void store(double* slot, Index quantity, const Vector<Quad>& v) {
  store(slot + quantity, v.x), store(slot + quantity + 4, v.y), store(slot + quantity + 8, v.z);
}

Vector<Quad> operator+(const Vector<Quad>& a, const Vector<Quad>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

Vector<Quad> operator-(const Vector<Quad>& a, const Vector<Quad>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

Vector<Quad> operator*(const Vector<Quad>& a, const Vector<Quad>& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// Does the same as addForce() of verlet_kernel.h for the springs of batches. A batch to the next strip also
/// reads and writes the numbers after x, y and z of its slot b: its last spring is missing, has no stiffness
/// and no damping, and adds 0 there.
template <bool kCrossings>
void addStripForces(const SpringBatchBody& body, Index begin, Index end, double crossing) {
  constexpr Index kX = StripBody::kPosition, kF = StripBody::kForce;
  const Index *as = body.springs.a, *bs = body.springs.b;
  double* slots = body.strips.numbers;
  const Quad *restLength = quads(body.springs.restLength),
             *extension = quads(body.springs.extensionStiffness),
             *compression = quads(body.springs.compressionStiffness);
  Quad* inverseLength = quads(body.springs.direction);
  for (Index i = begin; i < end; ++i) {
    double *a = slots + as[i], *b = slots + bs[i];
    const Vector<Quad> d = of(b, kX) - of(a, kX);
    const Pull<Quad> p = pullOf(dot(d, d), restLength[i], extension[i], compression[i]);
    inverseLength[i] = p.scale;
    const Vector<Quad> force = kCrossings ? scaled(crossedForce(body, i, p, crossing), scaled(p.inverse, d))
                                          : scaled(p.force, scaled(p.scale, d));
    store(a, kF, of(a, kF) + force);
    store(b, kF, of(b, kF) - force);
  }
}

/// Does the same as damp() of verlet_kernel.h for a batch.
void dampStrip(double* a, double* b, Quad inverseLength, Quad factor) {
  constexpr Index kX = StripBody::kPosition, kV = StripBody::kVelocity, kW = StripBody::kInverseMass;
  const Vector<Quad> n = scaled(inverseLength, of(b, kX) - of(a, kX));
  const Vector<Quad> va = of(a, kV), vb = of(b, kV);
  const Vector<Quad> impulse = scaled(factor * dot(n, vb - va), n);
  store(a, kV, va + impulse * of(a, kW));
  store(b, kV, vb - impulse * of(b, kW));
}

void dampStrips(const SpringBatchBody& body, const Quad* factors, bool forward, Index begin, Index end) {
  const Index *a = body.springs.a, *b = body.springs.b;
  double* slots = body.strips.numbers;
  const Quad* inverseLength = quads(body.springs.direction);
  const Index step = forward ? 1 : static_cast<Index>(-1);
  for (Index k = begin, i = forward ? begin : end - 1; k < end; ++k, i += step)
    dampStrip(slots + a[i], slots + b[i], inverseLength[i], factors[i]);
}

/// Calls visit(i) for the points or slots.
template <class Visit>
void forEachPoint(const BatchPoints& points, Visit visit) {
  if (!points.numbers)
    for (Index i = points.begin; i < points.end; ++i) visit(i);
  else
    for (Index k = points.begin; k < points.end; ++k) visit(points.numbers[k]);
}

/// Returns the number of points at a slot.
Index countAt(const StripBody& s, Index slot) {
  const Index count = (s.points - slot + s.slots - 1) / s.slots;
  return count < 4 ? count : 4;
}

/// Copies a quantity of points to their slots. The places of missing points get that of the point after the
/// body's last one.
void toSlots(const StripBody& s, const BatchPoints& slots, const double* points, Index quantity) {
  const Quad* p = quads(points);
  forEachPoint(slots, [&](Index slot) {
    const Index count = countAt(s, slot);
    const auto pointOf = [&](Index strip) { return strip < count ? strip * s.slots + slot : s.points; };
    store(s.numbers + StripBody::kNumbers * slot, quantity,
          columns(p[slot], p[pointOf(1)], p[pointOf(2)], p[pointOf(3)]));
  });
}

void fromSlots(const StripBody& s, const BatchPoints& slots, Index quantity, double* points) {
  Quad* p = quads(points);
  forEachPoint(slots, [&](Index slot) {
    const Index count = countAt(s, slot);
    const Rows r = rows(of(s.numbers + StripBody::kNumbers * slot, quantity));
    for (Index strip = 0; strip < count; ++strip) p[strip * s.slots + slot] = r.row[strip];
  });
}

// --- the volume terms ---

/// Does the same as sixVolumes() of verlet_kernel.h, but returns one sum per axis.
Quad sixBatchVolumes(const Volumes<double> v, Index component, const Quad* x) {
  Quad sum = all(Quad(), 0.0);
  const Quad o = x[v.corners[3 * v.firstTriangle[component]]];
  Quad* gradient = quads(v.gradient);
  for (Index t = v.firstTriangle[component]; t < v.firstTriangle[component + 1]; ++t) {
    const Index* corner = v.corners + 3 * t;
    const Quad a = x[corner[0]];
    const Quad b = x[corner[1]] - a, c = x[corner[2]] - a;
    const Quad n = rolled(b) * rolledBack(c) - rolledBack(b) * rolled(c);
    sum = sum + (a - o) * n;
    for (Index k = 0; k < 3; ++k) gradient[corner[k]] = gradient[corner[k]] + n;
  }
  return sum;
}

Vector<Quad> displacementFrom(const Quad* x, const Index* corners, Index to) {
  return columns(x[corners[to]] - x[corners[0]], x[corners[4 + to]] - x[corners[4]],
                 x[corners[8 + to]] - x[corners[8]], x[corners[12 + to]] - x[corners[12]]);
}

// --- contacts with planes ---

/// x, y and z of a quantity of four points.
void gather(const double* numbers, const Index* points, Quad* to) {
  const Quad* p = quads(numbers);
  const Vector<Quad> c = columns(p[points[0]], p[points[1]], p[points[2]], p[points[3]]);
  to[0] = c.x, to[1] = c.y, to[2] = c.z;
}

/// Of the places of a point that fills up a group, the first is written last: it has the contact.
void scatter(const Quad* from, const Index* points, double* numbers) {
  const Rows r = rows({from[0], from[1], from[2]});
  for (Index k = 4; k-- > 0;) quads(numbers)[points[k]] = r.row[k];
}

Capsule<Quad> spread(const Capsule<double>& c) {
  Capsule<Quad> all4;
  for (Index k = 0; k < 3; ++k) {
    all4.center[k] = all(Quad(), c.center[k]);
    all4.axis[k] = all(Quad(), c.axis[k]), all4.side[k] = all(Quad(), c.side[k]);
  }
  all4.half = all(Quad(), c.half), all4.radius = all(Quad(), c.radius);
  return all4;
}

/// Four points and their planes.
struct PlaneGroup {
  const PlaneBody& body;
  Index number;
  Plane<Quad>& plane;
  const Index* points;
  Quad x[3], v[3], w[3];

  PlaneGroup(const PlaneBody& b, Index i)
      : body(b), number(i), plane(reinterpret_cast<Plane<Quad>*>(b.planes)[i]), points(b.points + 4 * i) {}

  void load() {
    gather(body.position, points, x);
    gather(body.velocity, points, v);
    gather(body.inverseMass, points, w);
  }
  /// Lets the planes of the lanes with `mask` over 0 follow their capsule, for a drift of dt.
  void follow(double dt, double within, Quad mask) {
    if (body.capsuleOf[number] == PlaneBody::kFixed) return;
    Quad displacement[3];
    for (Index c = 0; c < 3; ++c) displacement[c] = all(Quad(), dt) * v[c];
    kernel::follow(plane, spread(body.capsules[body.capsuleOf[number]]), all(Quad(), body.radius), x,
                   displacement, all(Quad(), within * body.radius), w, mask);
  }
  void store() const { scatter(v, points, body.velocity); }
};

}  // namespace

void stopBatchPoints(const PlaneBody& body, Index begin, Index end, double time, double dt) {
  for (Index i = begin; i < end; ++i) {
    PlaneGroup group(body, i);
    group.load();
    group.follow(dt, kSearchBeyond, all(Quad(), 1.0));
    stopAtPlane(group.plane, group.x, group.v, group.w, time, dt);
    if (any(group.plane.least > all(Quad(), kNoLeast))) group.store();
  }
  leaveKernel();
}

void settleBatchPoints(const PlaneBody& body, Index begin, Index end) {
  const Quad none = all(Quad(), kNoLeast), zero = all(Quad(), 0.0);
  for (Index i = begin; i < end; ++i) {
    PlaneGroup group(body, i);
    if (!any(group.plane.least > none)) continue;
    group.load();
    group.follow(0.0, kSupportDistance, select(group.plane.least > none, all(Quad(), 1.0), zero));
    push(group.plane, select(group.plane.mass > zero, group.plane.least, none), group.v, group.w);
    group.store();
  }
  leaveKernel();
}

void clearBatchForces(const SpringBatchBody& b, const BatchPoints& points) {
  Quad* f = quads(b.points.force);
  forEachPoint(points, [=](Index i) { f[i] = all(Quad(), 0.0); });
}

void addBatchSprings(const SpringBatchBody& body, Index begin, Index end, double crossing) {
  if (body.strips.slots > 0) {
    if (body.springs.stretch) return addStripForces<true>(body, begin / 4, end / 4, crossing);
    return addStripForces<false>(body, begin / 4, end / 4, crossing);
  }
  const SpringBatchBody b = body;
  for (Index i = begin; i < end; i += 4) addForces(b, i, crossing);
}

/// Gives the same results as addVolumeForces() of verlet_kernel.h, to the bit.
void addBatchVolumes(const SpringBatchBody& body) {
  const Volumes<double> v = body.volumes;
  if (v.components == 0) return;
  const Quad *x = quads(body.points.position), *w = quads(body.points.inverseMass);
  Quad *force = quads(body.points.force), *gradient = quads(v.gradient), *sums = quads(v.sums);
  for (Index i = 0; i < v.points; ++i) gradient[i] = all(Quad(), 0.0);
  for (Index c = 0; c < v.components; ++c) {
    sums[2 * c] = sixBatchVolumes(v, c, x);
    sums[2 * c + 1] = all(Quad(), 0.0);
  }
  for (Index i = 0; i < v.points; ++i) {
    Quad& squares = sums[2 * v.componentOf[i] + 1];
    squares = squares + w[i] * gradient[i] * gradient[i];
  }
  for (Index c = 0; c < v.components; ++c)
    sums[2 * c] = stablePush(all(Quad(), total(sums[2 * c])), all(Quad(), total(sums[2 * c + 1])),
                             all(Quad(), v.restVolume[c]), all(Quad(), *v.modulus),
                             all(Quad(), *v.gasPressure), all(Quad(), *v.ambient), v.timeStep);
  for (Index i = 0; i < v.points; ++i) force[i] = force[i] + sums[2 * v.componentOf[i]] * gradient[i];
}

/// Gives the same results as addTetrahedronForces() of verlet_kernel.h, to the bit.
void addBatchTetrahedra(const SpringBatchBody& body, Index begin, Index end) {
  const Tetrahedra<double> t = body.tetrahedra;
  const Quad* x = quads(body.points.position);
  Quad* force = quads(body.points.force);
  for (Index i = begin; i < end; i += 4) {
    const Index* corners = t.corners + 4 * i;
    const CornerForces<Quad> f = tetrahedronForces(
        displacementFrom(x, corners, 1), displacementFrom(x, corners, 2), displacementFrom(x, corners, 3),
        quads(t.inverseRest)[i / 4], quads(t.stabilityScale)[i / 4], all(Quad(), *t.modulus),
        all(Quad(), *t.crushModulus));
    const Rows b = rows(f.b), c = rows(f.c), d = rows(f.d);
    for (Index k = 0; k < 4; ++k) {
      const Index* corner = corners + 4 * k;
      force[corner[0]] = force[corner[0]] - (b.row[k] + (c.row[k] + d.row[k]));
      force[corner[1]] = force[corner[1]] + b.row[k];
      force[corner[2]] = force[corner[2]] + c.row[k];
      force[corner[3]] = force[corner[3]] + d.row[k];
    }
  }
}

void kickBatchPoints(const SpringBatchBody& b, double dt, const BatchPoints& points) {
  const Quad time = all(Quad(), dt);
  Quad* v = quads(b.points.velocity);
  const Quad *a = quads(b.points.acceleration), *f = quads(b.points.force), *w = quads(b.points.inverseMass);
  forEachPoint(points, [=](Index i) { v[i] = v[i] + time * (a[i] + f[i] * w[i]); });
}

void driftBatchPoints(const SpringBatchBody& b, double dt, const BatchPoints& points) {
  const Quad time = all(Quad(), dt);
  Quad* x = quads(b.points.position);
  const Quad* v = quads(b.points.velocity);
  forEachPoint(points, [=](Index i) { x[i] = x[i] + time * v[i]; });
}

void dampBatchSprings(const SpringBatchBody& body, bool whole, bool forward, Index begin, Index end) {
  if (body.sweeps == 0) return;
  const Quad* factors = quads(whole ? body.dampFull : body.dampHalf);
  if (body.strips.slots > 0) return dampStrips(body, factors, forward, begin / 4, end / 4);
  const SpringBatchBody b = body;
  for (Index k = begin / 4; k < end / 4; ++k) {
    const Index g = forward ? k : begin / 4 + end / 4 - 1 - k;
    if (b.apart[g])
      dampTogether(b, 4 * g, factors[g]);
    else
      dampInTurn(b, 4 * g, factors[g], forward);
  }
  leaveKernel();
}

void loadSlots(const SpringBatchBody& b, const BatchPoints& slots, Index quantity) {
  const double* points = quantity == StripBody::kPosition   ? b.points.position
                         : quantity == StripBody::kVelocity ? b.points.velocity
                                                            : b.points.inverseMass;
  toSlots(b.strips, slots, points, quantity);
  if (quantity != StripBody::kPosition) return;
  const Quad zero = all(Quad(), 0.0);
  forEachPoint(slots, [&](Index slot) {
    store(b.strips.numbers + StripBody::kNumbers * slot, StripBody::kForce, {zero, zero, zero});
  });
}

void unloadSlots(const SpringBatchBody& b, const BatchPoints& slots, Index quantity) {
  fromSlots(b.strips, slots, quantity, quantity == StripBody::kForce ? b.points.force : b.points.velocity);
}

void computeBatchForces(const SpringBatchBody& b, double crossing) {
  const BatchPoints slots{0, b.strips.slots};
  clearBatchForces(b, {0, b.points.count});
  loadSlots(b, slots, StripBody::kPosition);
  addBatchSprings(b, 0, b.springs.count, crossing);
  unloadSlots(b, slots, StripBody::kForce);
  addBatchVolumes(b);
  addBatchTetrahedra(b, 0, b.tetrahedra.count);
}

void dampBatch(const SpringBatchBody& b, bool whole, bool forward) {
  const BatchPoints slots{0, b.strips.slots};
  loadSlots(b, slots, StripBody::kVelocity);
  dampBatchSprings(b, whole, forward, 0, b.springs.count);
  unloadSlots(b, slots, StripBody::kVelocity);
}

namespace {

/// A whole body in the form that stepAlone() takes. All its contacts are callbacks.
struct SteppedBatches : SpringBatchBody {
  void kick(double dt) const { kickBatchPoints(*this, dt, {0, points.count}); }
  void drift(double dt) const { driftBatchPoints(*this, dt, {0, points.count}); }
  void damp(bool whole, bool forward) const { dampBatch(*this, whole, forward); }
  void stopAtPlanes(double, double) const {}
  void settleAtPlanes() const {}
  bool anyLeaves(double) const { return false; }

  void computeForces(double crossing) const { computeBatchForces(*this, crossing); }
  double computeForcesAndChange(double crossing) const {
    const Quad *f = quads(points.force), *w = quads(points.inverseMass);
    Quad* earlier = quads(earlierForce);
    for (Index i = 0; i < points.count; ++i) earlier[i] = f[i];
    computeForces(crossing);
    Quad sum = all(Quad(), 0.0);
    for (Index i = 0; i < points.count; ++i) {
      const Quad change = (f[i] - earlier[i]) * w[i];
      sum = sum + change * change;
    }
    return total(sum);
  }
};

}  // namespace

double stepSpringBatches(const SpringBatchBody& body, double tick, int substeps) {
  return stepAlone<double>(SteppedBatches{body}, tick, substeps);
}

}  // namespace limber::kernel
