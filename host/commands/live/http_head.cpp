// SPDX-License-Identifier: Apache-2.0
#include "host/commands/live/http_head.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "hw/descriptor.h"

namespace tactel::host {
namespace {

constexpr const char* digits = "0123456789";

// Pages have their style and script within, ask "events" beside them alone, and stand in no frame.
constexpr const char* policy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; connect-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const char* reason(int status) {
  for (const auto& [number, words] : {std::pair{200, "OK"},
                                      {403, "Forbidden"},
                                      {404, "Not Found"},
                                      {405, "Method Not Allowed"},
                                      {408, "Request Timeout"},
                                      {431, "Request Header Fields Too Large"},
                                      {503, "Service Unavailable"}})
    if (number == status) return words;
  return "Bad Request";
}

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  return out;
}

/// The name or address of a Host, in small letters; none where it is no host.
std::optional<std::string> header_name(std::string_view host) {
  const bool bracket = host.starts_with('[');
  const std::size_t end = bracket ? host.find(']') : std::min(host.find(':'), host.size());
  if (end == std::string_view::npos || host.find('\0') != std::string_view::npos) return std::nullopt;
  const std::string_view port = host.substr(end + bracket), name = host.substr(bracket, end - bracket);
  if (!port.empty() && (port[0] != ':' || port.find_first_not_of(digits, 1) != std::string_view::npos))
    return std::nullopt;
  std::string found = lower(name);
  if (!bracket && found.size() > 1 && found.back() == '.') found.pop_back();
  return found;
}

/// Whether a literal is an address of this machine: the kernel binds no socket to another.
bool is_own_address(const std::string& literal) {
  sockaddr_in four{};
  sockaddr_in6 six{};
  four.sin_family = AF_INET, six.sin6_family = AF_INET6;
  const bool is_four = ::inet_pton(AF_INET, literal.c_str(), &four.sin_addr) == 1;
  if (!is_four && ::inet_pton(AF_INET6, literal.c_str(), &six.sin6_addr) != 1) return false;
  const hw::Descriptor probe(::socket(is_four ? AF_INET : AF_INET6, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  return (is_four ? ::bind(probe, reinterpret_cast<const sockaddr*>(&four), sizeof four)
                  : ::bind(probe, reinterpret_cast<const sockaddr*>(&six), sizeof six)) == 0;
}

/// Takes a line from the front of a head, without its end.
std::string_view next_line(std::string_view& head) {
  const std::size_t end = std::min(head.find("\r\n"), head.size());
  const std::string_view line = head.substr(0, end);
  head.remove_prefix(std::min(end + 2, head.size()));
  return line;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  return first == std::string_view::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// The one Host of the lines below a request; none where there are none or two, or a line is no field.
std::optional<std::string_view> host_of(std::string_view fields) {
  std::optional<std::string_view> host;
  for (std::string_view line = next_line(fields); !line.empty(); line = next_line(fields)) {
    const std::size_t colon = line.find(':');
    if (colon == 0 || colon == std::string_view::npos || line[0] == ' ' || line[0] == '\t') return std::nullopt;
    if (lower(line.substr(0, colon)) != "host") continue;
    if (host) return std::nullopt;
    host = trimmed(line.substr(colon + 1));
  }
  return host;
}

std::string printable(std::string_view text) {
  std::string out(text.substr(0, 100));
  std::ranges::replace_if(
      out, [](unsigned char c) { return c < 0x20 || c > 0x7E; }, '?');
  return out;
}

}  // namespace

bool answers_to(std::string_view host, const std::vector<std::string>& hosts) {
  const std::optional<std::string> name = header_name(host);
  if (!name || name->empty()) return false;
  return *name == "localhost" || std::ranges::find(hosts, name, header_name) != hosts.end() || is_own_address(*name);
}

HttpRequest read_head(std::string_view head, const std::vector<std::string>& hosts) {
  HttpRequest request;
  const std::string_view line = next_line(head);
  const std::size_t space = line.find(' '), second = line.find(' ', space + 1);
  const std::optional<std::string_view> host = host_of(head);
  if (second == std::string_view::npos || !line.substr(second + 1).starts_with("HTTP/1.") || !host) return request;
  const std::string_view target = line.substr(space + 1, second - space - 1);
  request.path = target.substr(0, target.find('?'));
  request.asked = printable(*host);
  request.status = !answers_to(*host, hosts) ? 403 : line.substr(0, space) != "GET" ? 405 : 200;
  return request;
}

std::string response_head(int status, std::string_view type, std::ptrdiff_t size) {
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: {}\r\n{}{}Connection: close\r\nCache-Control: no-store\r\n"
      "X-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\nContent-Security-Policy: {}\r\n"
      "Referrer-Policy: no-referrer\r\n\r\n",
      status, reason(status), type, size < 0 ? "" : fmt::format("Content-Length: {}\r\n", size),
      status == 405 ? "Allow: GET\r\n" : "", policy);
}

std::string refusal(int status, std::string_view why) {
  const std::string body = fmt::format("{} {}: {}\n", status, reason(status), why);
  return response_head(status, "text/plain; charset=utf-8", static_cast<std::ptrdiff_t>(body.size())) + body;
}

}  // namespace tactel::host
