// SPDX-License-Identifier: Zlib
// Contacts from the cache must equal those of a new search.
#include "collide/surface_contacts.h"

#include "support/moving_shapes.h"

#include <gtest/gtest.h>

namespace limber {
namespace {

using Eigen::Affine3d;
using Eigen::AngleAxisd;
using Eigen::Translation3d;
using Eigen::Vector3d;
using test::kMargin;
using test::kRadius;
using test::kRounding;
using test::MovingShape;

/// A cube on another, rotated and off-centre: with contacts of vertices with faces and of crossing edges.
struct Pile {
  MovingShape upper = test::boxShape(Vector3d::Ones(), kRadius);
  MovingShape lower = test::boxShape(Vector3d::Ones(), kRadius);
  ContactCache cache;

  Pile() {
    upper.move(Translation3d(0.3, 1.0 + 2.0 * kRadius + 0.001, 0.2) * AngleAxisd(0.4, Vector3d::UnitY()));
    storeContacts(upper.surface(), lower.surface(), test::contactsOf(upper, lower, kMargin), cache);
  }
  bool refresh() { return refreshContacts(upper.surface(), lower.surface(), kMargin, cache); }
};

TEST(ContactCache, areThoseOfANewSearch) {
  Pile pile;
  ASSERT_GE(pile.cache.contacts.size(), 4u);
  // 0.3 mm sideways and 0.2 mm down, 0.1 mrad about all axes: within a fifth of the margin
  pile.upper.move(Translation3d(3e-4, -2e-4, 0.0) * AngleAxisd(1e-4, Vector3d::Ones().normalized()));
  ASSERT_TRUE(pile.refresh());
  const std::vector<SurfaceContact> found = test::contactsOf(pile.upper, pile.lower, kMargin);
  ASSERT_EQ(found.size(), pile.cache.contacts.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const SurfaceContact& cached = pile.cache.contacts[i];
    EXPECT_EQ(cached.key, found[i].key);
    EXPECT_NEAR(cached.gap, found[i].gap, kRounding);
    EXPECT_NEAR((cached.normal - found[i].normal).norm(), 0.0, kRounding);
    EXPECT_NEAR((cached.a.weights - found[i].a.weights).norm(), 0.0, kRounding);
    EXPECT_NEAR((cached.b.weights - found[i].b.weights).norm(), 0.0, kRounding);
  }
}

TEST(ContactCache, goAlongWithBothSurfaces) {
  Pile pile;
  for (MovingShape* shape : {&pile.upper, &pile.lower}) {
    shape->move(Affine3d(Translation3d(3.0, -2.0, 1.0)));
    shape->setMotion({0.5, -0.5, 0.1});
  }
  EXPECT_TRUE(pile.refresh()) << "only motion against each other counts";
}

TEST(ContactCache, areNotTrustedAfterMoreThanAShareOfTheMargin) {
  Pile pile;
  pile.upper.move(Affine3d(Translation3d(0.3 * kMargin, 0.0, 0.0)));
  EXPECT_FALSE(pile.refresh());
}

TEST(ContactCache, areNotTrustedIfSomethingElseMayMeetWithinTheTick) {
  Pile pile;
  pile.upper.setMotion({0.0, -kMargin, 0.0});
  EXPECT_FALSE(pile.refresh());
}

TEST(ContactCache, areNotTrustedOnceAPlaceLeavesItsFeature) {
  MovingShape upper = test::boxShape(Vector3d::Ones(), kRadius);
  MovingShape lower = test::boxShape(Vector3d::Ones(), kRadius);
  // two corners of the upper cube are 0.1 mm inside the rim of the lower cube's face
  upper.move(Affine3d(Translation3d(1.0 - 1e-4, 1.0 + 2.0 * kRadius, 0.3)));
  ContactCache cache;
  storeContacts(upper.surface(), lower.surface(), test::contactsOf(upper, lower, kMargin), cache);
  ASSERT_FALSE(cache.contacts.empty());
  upper.move(Affine3d(Translation3d(9e-4, 0.0, 0.0)));
  EXPECT_FALSE(refreshContacts(upper.surface(), lower.surface(), kMargin, cache));
}

}  // namespace
}  // namespace limber
