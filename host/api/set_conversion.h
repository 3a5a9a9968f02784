// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/sweep.h>

#include "host/sets/contact_set.h"

namespace tactel::api {

/// Returns the rows and counts of a set as users have them.
Set from_host(host::ContactSet&& set);
/// Returns the rows as the rooms of host have them. Throws InputError naming `set` where its arrays differ in length.
host::ContactSet to_host(const Set& set);

}  // namespace tactel::api
