// SPDX-License-Identifier: Zlib
#pragma once

#include "solver/pair_contacts.h"

namespace limber {

/// Makes the impulses of a contact between bodies that move act along one line, as the bodies lie now, so
/// that they change no angular momentum. For contacts that are about to bear something: where others will
/// touch is not yet seen.
///
/// Let D = sum s_i x_i be the way from place b to place a, s_i the points' shares (below 0 on b). Impulses J
/// at the two places are a couple D x J. With y_i the points' ways across the normal n from the middle of
/// their side, M = sum y_i y_i^T, and D = d n + T,
///     s_i -= y_i . M^-1 T          moves the places until T is 0, and
///     J_i = s_i J + n (l_i . J),   l_i = d M^-1 y_i,
/// lets the levers of edges and triangles bear what is left, d n x J; neither changes the sum of a side. That
/// is the least change that does. The places' relative speed across grows by sum l_i (n . v_i): the surfaces
/// touch in the middle, and turn. A rigid body's place moves by what no soft one's can.
void joinPlaces(PairRows& rows, std::size_t contact);

}  // namespace limber
