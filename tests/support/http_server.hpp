// SPDX-License-Identifier: MIT
// A small HTTP server on this machine that also knows how to misbehave.
#pragma once

#include <arpa/inet.h>
#include <fmt/core.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace edvo::test {

struct HttpBehaviour {
  std::string body;
  int status = 200;
  bool knows_ranges = true;
  std::size_t hangs_up_after = std::string::npos;  // bytes of the body sent
  std::size_t stalls_after = std::string::npos;    // likewise, then silence
};

class HttpServer {
 public:
  explicit HttpServer(HttpBehaviour behaviour) : behaviour_(std::move(behaviour)) {
    setenv("no_proxy", "127.0.0.1", 1);
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    if (::bind(listener_, generic, size) != 0 || ::listen(listener_, 8) != 0 ||
        ::getsockname(listener_, generic, &size) != 0)
      throw std::runtime_error("no local server");
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve(); });
  }
  ~HttpServer() {
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  [[nodiscard]] std::string url() const {
    return fmt::format("http://127.0.0.1:{}/model.onnx", port_);
  }

  void behave(HttpBehaviour behaviour) {
    const std::scoped_lock lock(mutex_);
    behaviour_ = std::move(behaviour);
  }

  // Where each request so far wanted to begin [bytes].
  [[nodiscard]] std::vector<std::size_t> starts() const {
    const std::scoped_lock lock(mutex_);
    return starts_;
  }

 private:
  void serve() {
    for (int client; (client = ::accept(listener_, nullptr, nullptr)) >= 0; ::close(client)) {
      std::string request;
      char buffer[4096];
      while (request.find("\r\n\r\n") == std::string::npos) {
        const ssize_t count = ::recv(client, buffer, sizeof buffer, 0);
        if (count <= 0) break;
        request.append(buffer, static_cast<std::size_t>(count));
      }
      answer(client, request);
    }
  }

  void answer(int client, const std::string& request) {
    const std::string key = "Range: bytes=";
    const std::size_t place = request.find(key);
    std::size_t start = 0;
    if (place != std::string::npos)
      start = std::strtoul(request.c_str() + place + key.size(), nullptr, 10);
    HttpBehaviour behaviour;
    {
      const std::scoped_lock lock(mutex_);
      starts_.push_back(start);
      behaviour = behaviour_;
    }
    int status = behaviour.status;
    if (!behaviour.knows_ranges) start = 0;
    if (status == 200 && start > 0) status = start < behaviour.body.size() ? 206 : 416;
    const std::string body = status == 200 || status == 206 ? behaviour.body.substr(start) : "";
    send(client,
         fmt::format("HTTP/1.1 {} x\r\nContent-Length: {}\r\nConnection: close\r\n{}\r\n", status,
                     body.size(),
                     status == 206 ? fmt::format("Content-Range: bytes {}-{}/{}\r\n", start,
                                                 behaviour.body.size() - 1, behaviour.body.size())
                                   : ""));
    send(client, body.substr(0, std::min(behaviour.hangs_up_after, behaviour.stalls_after)));
    // Until the client gives up.
    char byte = 0;
    if (behaviour.stalls_after != std::string::npos) (void)::recv(client, &byte, 1, 0);
  }

  static void send(int client, const std::string& bytes) {
    for (std::size_t sent = 0; sent < bytes.size();) {
      const ssize_t count = ::send(client, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (count <= 0) return;
      sent += static_cast<std::size_t>(count);
    }
  }

  mutable std::mutex mutex_;
  HttpBehaviour behaviour_;
  std::vector<std::size_t> starts_;
  int listener_ = -1;
  int port_ = 0;
  std::thread thread_;
};

}  // namespace edvo::test
