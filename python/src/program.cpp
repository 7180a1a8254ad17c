// SPDX-License-Identifier: MIT
// The program's verbs: the same entry that the executable has, and what Python adds to it.
#include "program.hpp"

#include "observers.hpp"
#include "python_error.hpp"
#include "python_text.hpp"
#include "source.hpp"
#include "stop_signal.hpp"

#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace edvo::python {
namespace {

using Words = std::vector<std::string>;

// Deleted with the GIL, wherever the program lets go of it.
struct WatcherWithGil final : Observer {
  explicit WatcherWithGil(const nb::list& observers)
      : inner(std::make_unique<PythonObservers>(observers)) {}
  ~WatcherWithGil() override {
    const nb::gil_scoped_acquire gil;
    inner.reset();
  }
  WatcherWithGil(const WatcherWithGil&) = delete;
  WatcherWithGil& operator=(const WatcherWithGil&) = delete;
  void begin(const SourceInfo& source) override { inner->begin(source); }
  void frame(const FrameResult& result, const Frame& image) override {
    inner->frame(result, image);
  }
  void skipped(const SkippedFrame& frame) override { inner->skipped(frame); }
  [[nodiscard]] bool wants_keyframes() const override { return inner->wants_keyframes(); }
  void keyframe(const KeyframePtr& keyframe) override { inner->keyframe(keyframe); }
  void map_changed(std::span<const MapKeyframe> keyframes) override {
    inner->map_changed(keyframes);
  }
  void links(std::span<const LinkReport> links) override { inner->links(links); }
  void warning(const std::string& text) override { inner->warning(text); }
  void end(const RunOutcome& outcome) override { inner->end(outcome); }

  std::unique_ptr<PythonObservers> inner;
};

std::vector<app::Extension::Option> options_of(const nb::object& list) {
  std::vector<app::Extension::Option> options;
  for (auto& [name, type, help] :
       nb::cast<std::vector<std::tuple<std::string, std::string, std::string>>>(list))
    options.push_back({name, type, help});
  return options;
}

// Calls what the host has for a sequence, with the GIL.
nb::object ask_host(const nb::object& host, const char* method, const app::SequenceChoice& choice,
                    const app::Extension::Values& values) {
  const auto camera =
      choice.camera_file ? std::optional<std::string>(choice.camera_file->string()) : std::nullopt;
  return host.attr(method)(choice.path.string(), camera,
                           std::pair(choice.camera_size.width, choice.camera_size.height),
                           choice.depth_scale, values);
}

std::unique_ptr<RgbdSource> open_source(const nb::object& host, const app::SequenceChoice& choice,
                                        const app::Extension::Values& values) {
  const nb::gil_scoped_acquire gil;
  std::unique_ptr<RgbdSource> source;
  rethrow_python_errors([&] {
    const nb::object opened = ask_host(host, "open_source", choice, values);
    if (!opened.is_none())
      source = make_source(opened, {.first = choice.first, .max_frames = choice.max_frames},
                           app::stop_requested);
  });
  return source;
}

Words examine(const nb::object& host, const app::SequenceChoice& choice,
              const app::Extension::Values& values) {
  const nb::gil_scoped_acquire gil;
  Words findings;
  rethrow_python_errors(
      [&] { findings = nb::cast<Words>(ask_host(host, "examine", choice, values)); });
  return findings;
}

std::filesystem::path pull(const nb::object& host, const std::string& name) {
  const nb::gil_scoped_acquire gil;
  std::filesystem::path place;
  rethrow_python_errors([&] { place = nb::cast<std::string>(host.attr("pull")(name)); });
  return place;
}

std::unique_ptr<Observer> make_observer(const nb::object& host,
                                        const app::Extension::Values& values) {
  const nb::gil_scoped_acquire gil;
  std::unique_ptr<Observer> watcher;
  rethrow_python_errors([&] {
    const nb::list observers = nb::cast<nb::list>(host.attr("make_observers")(values));
    if (observers.size() > 0) watcher = std::make_unique<WatcherWithGil>(observers);
  });
  return watcher;
}

int call_verb(const nb::object& verb, const Words& words) {
  const nb::gil_scoped_acquire gil;
  int status = 0;
  rethrow_python_errors([&] { status = nb::cast<int>(verb(words)); }, ErrorCode::kInternal);
  return status;
}

// What edvo.cli.Host says. Objects are borrowed: the caller keeps the host.
app::Extension extension_of(const nb::object& host) {
  app::Extension extension{
      .source_options = options_of(host.attr("source_options")),
      .watch_options = options_of(host.attr("watch_options")),
      .open_source =
          [&host](const app::SequenceChoice& choice, const app::Extension::Values& values) {
            return open_source(host, choice, values);
          },
      .examine =
          [&host](const app::SequenceChoice& choice, const app::Extension::Values& values) {
            return examine(host, choice, values);
          },
      .pull = [&host](const std::string& name) { return pull(host, name); },
      .make_observer =
          [&host](const app::Extension::Values& values) { return make_observer(host, values); }};
  for (const nb::handle item : host.attr("verbs")) {
    const auto [name, help, call] =
        nb::cast<std::tuple<std::string, std::string, nb::object>>(item);
    PyObject* const function = call.ptr();  // kept by the host
    extension.verbs.push_back({name, help, [function](const Words& words) {
                                 const nb::gil_scoped_acquire gil;
                                 return call_verb(nb::borrow<nb::object>(function), words);
                               }});
  }
  return extension;
}

int run_program(Words arguments, const nb::object& host) {
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const app::Extension extension = host.is_none() ? app::Extension{} : extension_of(host);
  const nb::gil_scoped_release release;
  const int status = app::run_program(static_cast<int>(arguments.size()), argv.data(), extension);
  std::fflush(nullptr);
  return status;
}

}  // namespace

void add_program(nb::module_& module) {
  using namespace nb::literals;
  module.attr("version") = EDVO_VERSION;
  module.def("main", run_program, "arguments"_a, "host"_a = nb::none());
}

}  // namespace edvo::python
