// SPDX-License-Identifier: Apache-2.0
#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>

#include "host/commands/live/live_server.h"
#include "host/support/errors.h"
#include "hw/descriptor.h"

namespace tactel::host {
namespace {

constexpr int waiting_connections = 64;
constexpr int send_buffer = 1 << 17;  // bytes: what a browser that does not read may hold

struct Place {
  std::string address = "127.0.0.1", port;
};

[[noreturn]] void refuse_place(const std::string& place, const std::string& fix) {
  throw ConfigError("command line", "--serve", place, fix);
}

[[noreturn]] void refuse_listening(const std::string& place, const char* why) {
  refuse_place(place, fmt::format("an address of this machine and a port that is free, 0 takes one; {}", why));
}

Place place_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  Place place{.port = colon == std::string::npos ? text : text.substr(colon + 1)};
  int port = -1;
  const auto [end, error] = std::from_chars(place.port.data(), place.port.data() + place.port.size(), port);
  if (error != std::errc() || end != place.port.data() + place.port.size() || port < 0 || port > 65535)
    refuse_place(text, "PORT or ADDRESS:PORT, a port of 0 to 65535");
  if (colon == std::string::npos) return place;
  place.address = text.substr(0, colon);
  if (place.address.starts_with('[') && place.address.ends_with(']'))
    place.address = place.address.substr(1, place.address.size() - 2);
  if (place.address.empty() || place.address == "*") place.address = "0.0.0.0";
  if (place.address == "localhost") place.address = "127.0.0.1";
  return place;
}

/// "127.0.0.1" or "[::1]"; of an IPv4 address within IPv6 that one.
std::string host_text(const sockaddr& address) {
  char text[INET6_ADDRSTRLEN] = "";
  if (address.sa_family == AF_INET) {
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in&>(address).sin_addr, text, sizeof text);
    return text;
  }
  const in6_addr& six = reinterpret_cast<const sockaddr_in6&>(address).sin6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&six)) return ::inet_ntop(AF_INET, six.s6_addr + 12, text, sizeof text);
  ::inet_ntop(AF_INET6, &six, text, sizeof text);
  return fmt::format("[{}]", text);
}

bool is_any(const sockaddr& address) {
  if (address.sa_family == AF_INET) return reinterpret_cast<const sockaddr_in&>(address).sin_addr.s_addr == INADDR_ANY;
  return IN6_IS_ADDR_UNSPECIFIED(&reinterpret_cast<const sockaddr_in6&>(address).sin6_addr);
}

/// Addresses of this machine that others reach; without those of one link, which browsers do not take.
std::vector<std::string> reachable(bool six) {
  std::vector<std::string> found;
  ifaddrs* first = nullptr;
  if (::getifaddrs(&first) != 0) return found;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> all(first, ::freeifaddrs);
  for (const ifaddrs* one = first; one; one = one->ifa_next) {
    if (!one->ifa_addr || (one->ifa_addr->sa_family != AF_INET && (!six || one->ifa_addr->sa_family != AF_INET6)))
      continue;
    const std::string text = host_text(*one->ifa_addr);
    if (!text.starts_with("127.") && text != "[::1]" && !text.starts_with("[fe80")) found.push_back(text);
  }
  return found;
}

/// Opens, binds and listens; -1 with errno where that fails.
hw::Descriptor listening_socket(const addrinfo& at) {
  hw::Descriptor file(::socket(at.ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int yes = 1, no = 0;
  if (file < 0) return file;
  // Not SO_REUSEPORT: a port that is taken is one.
  ::setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  ::setsockopt(file, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);  // connections inherit this, and the next
  ::setsockopt(file, SOL_SOCKET, SO_SNDBUF, &send_buffer, sizeof send_buffer);
  if (at.ai_family == AF_INET6) ::setsockopt(file, IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof no);
  if (::bind(file, at.ai_addr, at.ai_addrlen) == 0 && ::listen(file, waiting_connections) == 0) return file;
  return hw::Descriptor();
}

}  // namespace

Listening listen_at(const std::string& text) {
  const Place place = place_of(text);
  addrinfo hints{}, *first = nullptr;
  hints.ai_socktype = SOCK_STREAM, hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  if (const int error = ::getaddrinfo(place.address.c_str(), place.port.c_str(), &hints, &first))
    refuse_listening(text, error == EAI_SYSTEM ? std::strerror(errno) : ::gai_strerror(error));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> found(first, ::freeaddrinfo);
  Listening at;
  for (const addrinfo* one = first; one && at.socket < 0; one = one->ai_next) at.socket = listening_socket(*one);
  if (at.socket < 0) refuse_listening(text, std::strerror(errno));
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  ::getsockname(at.socket, reinterpret_cast<sockaddr*>(&bound), &size);
  const sockaddr& address = reinterpret_cast<const sockaddr&>(bound);
  const int port = ntohs(address.sa_family == AF_INET ? reinterpret_cast<const sockaddr_in&>(bound).sin_port
                                                      : reinterpret_cast<const sockaddr_in6&>(bound).sin6_port);
  const auto url = [port](const std::string& host) { return fmt::format("http://{}:{}/", host, port); };
  if (!is_any(address)) {
    at.address = url(host_text(address));
    return at;
  }
  at.address = url(address.sa_family == AF_INET ? "127.0.0.1" : "[::1]");
  for (const std::string& host : reachable(address.sa_family == AF_INET6)) at.others.push_back(url(host));
  return at;
}

void check_serve_host(const std::string& name) {
  constexpr const char* allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._";
  if (name.empty() || name.find_first_not_of(allowed) != std::string::npos)
    throw ConfigError("command line", "--serve-host", name, "the name of a host alone, as robot.local");
}

}  // namespace tactel::host
