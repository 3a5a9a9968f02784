// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "hw/descriptor.h"

namespace tactel::host {

/// A socket that listens, and where browsers find it.
struct Listening {
  hw::Descriptor socket;            ///< accepting never waits
  std::string address;              ///< "http://127.0.0.1:8080/", of this machine
  std::vector<std::string> others;  ///< the same for other machines; empty: none reach it, or there is one address
};

/// Listens at "PORT", of 127.0.0.1, or at "ADDRESS:PORT": "[::1]:8080", "localhost:8080"; "0.0.0.0:8080", "*:8080" and
/// ":8080" are all addresses. Port 0: one that is free. Throws ConfigError where it is neither, or with the reason why
/// it cannot be listened at.
Listening listen_at(const std::string& place);

/// Throws ConfigError where --serve-host is no name of a host.
void check_serve_host(const std::string& name);

}  // namespace tactel::host
