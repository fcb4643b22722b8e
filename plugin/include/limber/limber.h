// SPDX-License-Identifier: Zlib
#pragma once

// All public headers, in the order of the data flow: mesh -> points and springs -> a body in the world.
#include <limber/contact_listener.h>
#include <limber/fast_spheres.h>
#include <limber/material_network.h>
#include <limber/mesh_import.h>
#include <limber/mesh_weld.h>
#include <limber/network_analysis.h>
#include <limber/network_builder.h>
#include <limber/network_file.h>
#include <limber/result.h>
#include <limber/simplify_mesh.h>
#include <limber/skin.h>
#include <limber/soft_body.h>
#include <limber/soft_body_settings.h>
#include <limber/soft_body_system.h>
#include <limber/soft_contact.h>
#include <limber/spring_constraint.h>
#include <limber/spring_network.h>
#include <limber/spring_settings.h>
#include <limber/surface_hit.h>
#include <limber/triangle_mesh.h>
