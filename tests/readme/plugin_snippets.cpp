// SPDX-License-Identifier: Zlib
// The code of plugin/README.md compiles: each piece is a file, which the page shows word for word.
#include <limber/limber.h>

void changeSettings(limber::SoftBody* body) {
#include "snippets/change.inc"
}

bool isIce(int triangle) { return triangle % 2 == 0; }

void filterContacts(limber::SoftBodySystem& soft, const btCollisionObject* belt,
                    const btCollisionObject* platform, const btCollisionObject* terrain,
                    const btCollisionObject* zone) {
#include "snippets/filter.inc"
}

void addField(limber::SoftBodySystem& soft) {
#include "snippets/field.inc"
}
