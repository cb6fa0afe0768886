// SPDX-License-Identifier: LGPL-3.0-or-later
// The session of a test program, which has but one.
#pragma once

#include "fem/session.hpp"

namespace grus::fem::test {

extern const Session* session;

}  // namespace grus::fem::test
