// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace tactel::host {

/// What the head of a request asks of a server that knows GET alone (RFC 9112).
struct HttpRequest {
  int status = 400;   ///< 200; or why there is no answer: 400 no request, 403 a foreign host, 405 another method
  std::string path;   ///< without its query
  std::string asked;  ///< the host that it names, printable; empty: none
};

/// Reads a head, its empty line included. `hosts`: as answers_to.
HttpRequest read_head(std::string_view head, const std::vector<std::string>& hosts);

/// Returns whether a Host, with or without a port, is this machine: localhost, an address of it, or one of `hosts`, in
/// any case and with or without a last dot. A page elsewhere whose name leads here (DNS rebinding) has a host of its
/// own, and is not answered.
bool answers_to(std::string_view host, const std::vector<std::string>& hosts);

/// Returns a head whose body is of `type`, and ends with the connection; `size` < 0: that is all that is known.
std::string response_head(int status, std::string_view type, std::ptrdiff_t size);
/// Returns a whole response that is no page: its status, and `why` in words.
std::string refusal(int status, std::string_view why);

}  // namespace tactel::host
