// SPDX-License-Identifier: Zlib
#pragma once

// All public headers, in the order of the data flow: mesh -> points and springs -> a body in the world.
//
// Meshes, networks and settings have Eigen's vectors in double precision, and so has everything that Limber
// computes itself (positions, velocities, momenta). Where the user passes or gets values of Bullet's objects
// (pivots, targets, contacts), vectors are Bullet's.
//
// Units are SI. Thread rules: functions of mesh.h, spring_network.h, network_builder.h, network_analysis.h,
// cook.h and soft_body_settings.h may be called from any thread, since calls are independent. Everything in a
// world belongs to the thread that steps the world.
//
// importMesh() needs the library limber_import, analyse() the library limber_analysis.
#include <limber/contact_filter.h>
#include <limber/contacts.h>
#include <limber/cook.h>
#include <limber/grab.h>
#include <limber/mesh.h>
#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/parallel.h>
#include <limber/parallel_for.h>
#include <limber/result.h>
#include <limber/skeleton.h>
#include <limber/soft_body.h>
#include <limber/soft_body_settings.h>
#include <limber/soft_body_system.h>
#include <limber/spring_constraint.h>
#include <limber/spring_network.h>
#include <limber/surroundings.h>
