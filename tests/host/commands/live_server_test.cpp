// SPDX-License-Identifier: Apache-2.0

// The server of monitor --serve, by connections of its own, most of which mean it ill.
#include "host/commands/live/live_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <utility>
#include <vector>

#include "host/commands/live/http_head.h"
#include "host/support/errors.h"
#include "host/support/seconds.h"
#include "tests/thrown_message.h"

namespace tactel::host::live_server_test {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

const std::string page = "<p>a page</p>";

/// A connection to a server at 127.0.0.1.
class Connection {
 public:
  explicit Connection(const LiveServer& server, int receive_buffer = 0) : file_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (receive_buffer > 0) ::setsockopt(file_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    const timeval longest{10, 0};
    ::setsockopt(file_, SOL_SOCKET, SO_RCVTIMEO, &longest, sizeof longest);
    const std::string address = server.address();
    sockaddr_in to{};
    to.sin_family = AF_INET, to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    EXPECT_EQ(::connect(file_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  }
  ~Connection() { ::close(file_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  /// Returns whether the server takes it.
  bool send(const std::string& text) const {
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t size = ::send(file_, text.data() + at, text.size() - at, MSG_NOSIGNAL);
      if (size < 0) return false;
      at += static_cast<std::size_t>(size);
    }
    return true;
  }
  void get(const std::string& path, const std::string& host = "localhost") const {
    send("GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
  }
  /// Reads until `end` stands in what came, or the server closes.
  std::string receive(const std::string& end = "\1") {
    char bytes[4096];
    while (found_.find(end) == std::string::npos) {
      const ssize_t size = ::recv(file_, bytes, sizeof bytes, 0);
      if (size <= 0) break;
      found_.append(bytes, static_cast<std::size_t>(size));
    }
    return found_;
  }
  std::string answer(const std::string& request) {
    send(request);
    return receive();
  }

 private:
  int file_;
  std::string found_;
};

std::string answer_of(const LiveServer& server, const std::string& path, const std::string& host = "localhost") {
  Connection connection(server);
  connection.get(path, host);
  return connection.receive();
}

std::vector<std::unique_ptr<Connection>> connections(const LiveServer& server, int count) {
  std::vector<std::unique_ptr<Connection>> all;
  for (int k = 0; k < count; ++k) all.push_back(std::make_unique<Connection>(server));
  return all;
}

std::ptrdiff_t open_descriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
}

double resident_megabytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6;
}

TEST(LiveServer, GivesItsPageAndNothingElse) {
  const LiveServer server("0", page);
  EXPECT_THAT(answer_of(server, "/"), AllOf(StartsWith("HTTP/1.1 200 OK\r\n"), HasSubstr("\r\nContent-Length: 13\r\n"),
                                            EndsWith("\r\n\r\n" + page)));
  EXPECT_THAT(answer_of(server, "/?again"), EndsWith(page));
  EXPECT_THAT(answer_of(server, "/favicon.ico"), StartsWith("HTTP/1.1 404 "));
  EXPECT_THAT(Connection(server).answer("POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 2\r\n\r\nhi"),
              AllOf(StartsWith("HTTP/1.1 405 "), HasSubstr("\r\nAllow: GET\r\n")));
  for (const char* wrong : {"GET / HTTP/1.1\r\n\r\n", "GET /\r\nHost: localhost\r\n\r\n", "\x16\x03\x01 a hello of TLS",
                            "GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n",
                            "GET / HTTP/1.1\r\nHost: localhost\r\n folded: x\r\n\r\n"})
    EXPECT_THAT(Connection(server).answer(wrong), StartsWith("HTTP/1.1 400 ")) << wrong;
}

// No other page frames it, and it sends nothing elsewhere, whatever text of a sensor should come to run in it.
TEST(LiveServer, EveryAnswerSaysWhatAPageMayDo) {
  const LiveServer server("0", page);
  for (const char* path : {"/", "/other"})
    EXPECT_THAT(
        answer_of(server, path),
        AllOf(HasSubstr("\r\nX-Frame-Options: DENY\r\n"), HasSubstr("\r\nContent-Security-Policy: default-src 'none';"),
              HasSubstr("frame-ancestors 'none'"), HasSubstr("\r\nX-Content-Type-Options: nosniff\r\n")));
}

TEST(LiveServer, StreamsTheNewestLineThenEachAndTheEnd) {
  auto server = std::make_unique<LiveServer>("0", page);
  server->send("{\"frame\": 0}");
  server->send("{\"frame\": 1}");
  Connection connection(*server);
  connection.get("/events");
  EXPECT_THAT(connection.receive("1}\n\n"),
              AllOf(HasSubstr("Content-Type: text/event-stream\r\n"), EndsWith("\r\n\r\ndata: {\"frame\": 1}\n\n")));
  server->send("{\"frame\": 2}");
  server->send("{\"seconds\": 1.0}", "silence");
  EXPECT_THAT(connection.receive("1.0}\n\n"),
              EndsWith("data: {\"frame\": 2}\n\nevent: silence\ndata: {\"seconds\": 1.0}\n\n"));
  server.reset();
  EXPECT_THAT(connection.receive(), EndsWith("event: end\ndata: the source has ended\n\n"));
}

TEST(LiveServer, ABrowserThatDoesNotReadMissesTheOldest) {
  auto server = std::make_unique<LiveServer>("0", page);
  Connection connection(*server, 2048);
  connection.get("/events");
  connection.receive("\r\n\r\n");
  const std::string filler(10'000, ' ');
  for (int k = 0; k < 300; ++k) server->send(fmt::format("{}{}", k, filler));  // 3 MB; 64 lines are kept
  server->send("newest");
  const std::string found = connection.receive("newest");
  EXPECT_THAT(found, HasSubstr("data: newest"));
  EXPECT_LT(found.size(), 1'500'000u);  // those, and what the system holds on both sides
}

// A page of another site may have its name lead here: its browser names that site, and gets nothing.
TEST(LiveServer, AnswersToThisMachineAlone) {
  const std::vector<std::string> hosts{"Robot.local"};
  for (const char* own : {"localhost", "localhost:8080", "LocalHost.:8080", "127.0.0.1:8080", "127.0.0.7", "[::1]:8080",
                          "robot.local", "ROBOT.LOCAL.:80"})
    EXPECT_TRUE(answers_to(own, hosts)) << own;
  for (const char* foreign :
       {"", "evil.example", "127.evil.example", "127.0.0.1.evil.example:80", "localhost.evil.example",
        "evil.example/localhost", "localhost:8080.evil.example", "local", "203.0.113.1", "[2001:db8::1]", "[::1",
        "[::1]x", "robot", "not-robot.local", "robot.local:x"})
    EXPECT_FALSE(answers_to(foreign, hosts)) << foreign;
  const LiveServer server("0", page, hosts);
  EXPECT_THAT(answer_of(server, "/events", "127.evil.example:8080"),
              AllOf(StartsWith("HTTP/1.1 403 "), HasSubstr("\"127.evil.example:8080\" is no name of this machine"),
                    HasSubstr("--serve-host 127.evil.example\n"), Not(HasSubstr("event-stream"))));
  EXPECT_THAT(answer_of(server, "/", "robot.local"), EndsWith(page));
}

TEST(LiveServer, AHeadWithoutEndIsRefusedAndNotKept) {
  const LiveServer server("0", page);
  Connection connection(server);
  const double before = resident_megabytes();
  const std::string line = "X-Long: " + std::string(100'000, 'y') + "\r\n";
  connection.send("GET / HTTP/1.1\r\nHost: localhost\r\n");
  for (int k = 0; k < 500 && connection.send(line); ++k) {
  }
  EXPECT_LT(resident_megabytes() - before, 20);  // of 50 MB; pages of buffers of this test are a few
  EXPECT_THAT(connection.receive(), AllOf(StartsWith("HTTP/1.1 431 "), HasSubstr("more than 8 kB")));
  EXPECT_THAT(answer_of(server, "/"), EndsWith(page));
}

TEST(LiveServer, ARequestWithoutEndEndsAfterFiveSeconds) {
  const LiveServer server("0", page);
  Connection connection(server);
  const auto start = Clock::now();
  connection.send("GET / HTTP/1.1\r\n");
  EXPECT_THAT(connection.receive(), StartsWith("HTTP/1.1 408 "));
  EXPECT_GT(seconds_since(start), 4.9);
}

// Clients that send half a head, or do not read, are no reason to wait at the end.
TEST(LiveServer, NoClientDelaysTheEnd) {
  auto server = std::make_unique<LiveServer>("0", page);
  const auto halves = connections(*server, 20);
  for (const auto& half : halves) half->send("GET / HTTP/1.1\r\nX: ");
  const Connection deaf(*server, 2048);
  deaf.get("/events");
  EXPECT_THAT(answer_of(*server, "/"), EndsWith(page));
  server->send(std::string(1'000'000, ' '));
  const auto start = Clock::now();
  server.reset();
  EXPECT_LT(seconds_since(start), 1);  // 0.3 for who does not read, and a busy machine
}

// Connections beyond its places wait in vain, but take no descriptors; the next one that asks is answered.
TEST(LiveServer, IdleConnectionsLeaveDescriptorsAndPlaces) {
  const LiveServer server("0", page);
  const std::ptrdiff_t before = open_descriptors();
  const auto idle = connections(server, 200);
  const auto start = Clock::now();
  std::string answer = answer_of(server, "/");
  EXPECT_LE(open_descriptors() - before, 200 + 80);
  while (!answer.ends_with(page) && seconds_since(start) < 10) answer = answer_of(server, "/");
  EXPECT_THAT(answer, EndsWith(page));
  EXPECT_LT(seconds_since(start), 4);  // before the idle ones are five seconds old
}

TEST(LiveServer, BrowsersBeyondItsPlacesAreTold) {
  LiveServer server("0", page);
  const auto streams = connections(server, 64);
  for (const auto& one : streams) one->get("/events"), one->receive("\r\n\r\n");
  EXPECT_THAT(answer_of(server, "/"), AllOf(StartsWith("HTTP/1.1 503 "), HasSubstr("64 browsers are here already")));
  server.send("newest");
  for (const auto& one : streams) EXPECT_THAT(one->receive("newest"), HasSubstr("data: newest"));
}

TEST(LiveServer, ListensWhereItIsTold) {
  for (const auto& [place, address] :
       {std::pair("0", "http://127.0.0.1:"), std::pair("127.0.0.1:0", "http://127.0.0.1:"),
        std::pair("localhost:0", "http://127.0.0.1:"), std::pair("[::1]:0", "http://[::1]:"),
        std::pair("::1:0", "http://[::1]:"), std::pair("0.0.0.0:0", "http://127.0.0.1:"),
        std::pair(":0", "http://127.0.0.1:"), std::pair("*:0", "http://127.0.0.1:"),
        std::pair("[::]:0", "http://[::1]:")}) {
    const LiveServer server(place, page);
    EXPECT_THAT(server.address(), StartsWith(address)) << place;
    if (!server.address().starts_with("http://127")) continue;
    EXPECT_THAT(answer_of(server, "/"), EndsWith(page)) << place;
  }
  EXPECT_THAT(LiveServer("0", page).others(), IsEmpty());
}

TEST(LiveServer, SaysWhyItCannotListen) {
  const LiveServer server("0", page);
  const auto why = [](const std::string& place) {
    return thrown_message<ConfigError>([&] { const LiveServer wrong(place, page); });
  };
  const std::string address = server.address(), taken = address.substr(7, address.size() - 8);
  EXPECT_THAT(why(taken), AllOf(HasSubstr("--serve = " + taken), HasSubstr("a port that is free"),
                                HasSubstr("Address already in use")));
  EXPECT_THAT(why("203.0.113.1:0"), HasSubstr("Cannot assign requested address"));
  EXPECT_THAT(why("no such host:80"), HasSubstr("an address of this machine"));
  for (const char* name : {"", "http://robot", "robot:8080", "*.local"})
    EXPECT_THAT(thrown_message<ConfigError>([&] { check_serve_host(name); }), HasSubstr("the name of a host alone"))
        << name;
  for (const char* place : {"x", "", "80x", "-1", "65536", "127.0.0.1:", "127.0.0.1"})
    EXPECT_THAT(why(place), HasSubstr("PORT or ADDRESS:PORT")) << place;
}

}  // namespace tactel::host::live_server_test
