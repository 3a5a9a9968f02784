// SPDX-License-Identifier: Apache-2.0

// Heads of requests, as `monitor --serve` reads them. What is answered names this machine once.
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "host/commands/live/http_head.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const std::vector<std::string> hosts = {"robot", "[2001:db8::7]:8080"};

const Target http_head("http_head", [](Bytes input) {
  std::string head = std::string(input.begin(), input.end()) + "\r\n\r\n";
  head.resize(head.find("\r\n\r\n") + 4);  // where the server cuts
  const host::HttpRequest request = host::read_head(head, hosts);
  const std::string& asked = request.asked;
  check(std::ranges::count(std::array{200, 400, 403, 405}, request.status) == 1, "a head has one of four answers");
  check(std::ranges::all_of(asked, [](unsigned char c) { return c >= 0x20 && c <= 0x7E; }), "a host can be shown");
  check(asked.size() <= 100, "a host that is shown is short");
  check(request.path.find_first_of(" ?") == std::string::npos, "a path has no query");
  if (request.status == 400) return;
  if (asked.size() < 100)  // whole
    check(host::answers_to(asked, hosts) == (request.status != 403), "what is answered names this machine");
  head.insert(head.size() - 2, "hOST: localhost\r\n");
  check(host::read_head(head, hosts).status == 400, "a second host is refused");
});

}  // namespace
}  // namespace tactel::fuzz
