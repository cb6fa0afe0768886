// SPDX-License-Identifier: LGPL-3.0-or-later
#include "dem/state/boundary.hpp"

namespace grus::dem {

double Cell::height() const { return 1 / vectors.inverse().rowwise().norm().maxCoeff(); }

}  // namespace grus::dem
