// SPDX-License-Identifier: Zlib
#pragma once

// The shapes of this folder, one function for each.

#include "triangle_soup.h"

namespace shapes {

/// Edge length 1 m, centred at the origin; the picture once on each face.
TriangleSoup makeCube();

/// An L of 12 x 4 cubic cells of 0.25 m in a box of 1 m, its surface split into the faces of the cells.
TriangleSoup makeLShape();

/// A ball of radius 0.5 m: an icosahedron with each triangle split into 16.
TriangleSoup makeIcosphere();

/// The icosphere with a spike at each corner of the icosahedron; the tips are 0.588 m from the centre.
TriangleSoup makeStar();

/// 16 segments around the y axis with 8 sides each, 1 m wide.
TriangleSoup makeTorus();

/// Along the y axis, 1 m high, with a fan of triangles at each end.
TriangleSoup makeCylinder();

/// A standing figure, 1 m high, with arms, legs and ears, that looks along +z. The picture is projected from
/// the front.
TriangleSoup makeFigure();

/// A cow, 1 m long, that stands on y = 0 and looks along +z: thin legs, horns, ears, a tail and an udder. One
/// closed piece.
TriangleSoup makeAnimal();

/// A gingerbread man, 1 m high, that stands on y = 0 and looks along +z: one flat sheet without thickness in
/// the plane z = 0, with holes for eyes, mouth and buttons.
TriangleSoup makePuppet();

/// A teapot, 1 m from handle to spout, that stands on y = 0; its spout points along +x. Three open pieces,
/// which intersect each other or leave gaps: a body with a handle, open at the top; a spout, open at both
/// ends, that sticks in the body's wall; a lid that lies loosely in the opening, its knob wound the other way
/// round.
TriangleSoup makeTeapot();

/// The head of a monkey, 1 m wide, that looks along +z. Its skin has holes at the eyes, the mouth and the
/// neck; the eyeballs are separate closed balls behind the holes.
TriangleSoup makeHead();

/// An ogre, 1.8 m high, that stands on y = 0, looks along +z and carries a club. Forty loose pieces, closed
/// ones and open sheets, which overlap, touch or float near each other.
TriangleSoup makeOgre();

/// A sitting rabbit as a scanner would see it, in decimetres: 1.6 high, on y = 0, looks along +z. The surface
/// is bumpy, the points are noisy and irregular, and about 200 open edges surround the places that the
/// scanner did not see: two holes in the base, under the chin, between the ears, beside the hind legs.
TriangleSoup makeBunny();

/// A round car, 4 m long, that stands on y = 0 and drives along +z. Its body consists of open sheets without
/// thickness: shell, roof, doors, bonnet, engine lid, fenders, floor, bumpers. They meet at gaps or cross
/// each other; the windows are holes. The wheels and lamps are closed.
TriangleSoup makeCar();

}  // namespace shapes
