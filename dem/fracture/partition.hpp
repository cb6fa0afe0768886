// SPDX-License-Identifier: LGPL-3.0-or-later
// Labelled points to convex parts that tile a body: classes whose heights are linear in x meet in planes (a power
// diagram), so nothing of the body is lost and no two parts overlap.
#pragma once

#include <span>
#include <vector>

#include "dem/shape/polyhedron.hpp"

namespace grus::dem {

/// What of a body is highest for this class is its part.
struct LinearClass {
  Vec3 slope;  // 1/m
  double bias;

  double height(const Vec3& x) const { return slope.dot(x) + bias; }
};

/// The class that is highest at x; of several the first.
std::size_t class_at(std::span<const LinearClass> classes, const Vec3& x);

/// Classes 0 to count - 1 that tell the labels of points apart: the most likely multinomial logistic model, slopes held
/// back by a weight of 1e-8 a point, so that labels which a plane parts are parted by one between them. `size` of the
/// points (m). Newton's method from equal classes; the same bits for the same points.
std::vector<LinearClass> fit_classes(std::span<const Vec3> points, std::span<const int> label, std::size_t count,
                                     double size);

/// The part of each class, empty where it has none; faces towards class b are tagged `fresh + b`, the body's own keep
/// their tags, which are below `fresh`.
std::vector<Polyhedron> parts_of(const Polyhedron& body, std::span<const LinearClass> classes, std::int64_t fresh);

/// Moves the classes as little as is needed, so that their planes go through corners of the body, or of one another,
/// that they came nearer to than `least` (m). Corners that no four numbers a class can bring together stay.
void join_corners(const Polyhedron& body, std::int64_t fresh, double least, std::vector<LinearClass>& classes);

/// Least width between a face and the corners over the largest distance of two corners: no wedge is thin.
double stoutness(const Polyhedron& body);

/// How a body is parted.
struct PartingRules {
  double least_stoutness = 0.15;  // of a part; its class is joined to that with which it shares the largest face
  double least_edge = 1e-3;       // of the body's size: corners nearer than this become one
};

struct Parting {
  std::vector<Polyhedron> part;  // at least two, or none: the body stays whole
  std::vector<std::size_t> of;   // of each part its label, of those joined the lowest
  double misfit = 0;             // share of the points that lie in another class's part
  int joined = 0;                // classes that were given up: thin wedges, and such as have no part
};

/// Parts of a body by the labels of points in it (0 to count - 1; below 0: of nobody), tagged as `parts_of` has it.
Parting part_by_labels(const Polyhedron& body, std::span<const Vec3> points, std::vector<int> label, std::size_t count,
                       std::int64_t fresh, const PartingRules& rules);

}  // namespace grus::dem
