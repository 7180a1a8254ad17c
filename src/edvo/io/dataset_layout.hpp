// SPDX-License-Identifier: MIT
// The folder layouts of RGB-D sequences that edvo reads.
#pragma once

#include "edvo/io/dataset.hpp"

namespace edvo {

// The frames found in a folder.
struct Listing {
  std::string layout;
  std::vector<FrameEntry> frames;  // ordered by stamp
  std::size_t colour_count = 0, depth_count = 0;
  double usual_depth_scale = 5000;  // [units/m] of this layout
  bool shrink_colour = false;       // see Dataset
  std::vector<std::string> notes, warnings;
};

// The frames of the first layout that matches; none if no layout does.
[[nodiscard]] std::optional<Listing> list_frames(const std::filesystem::path& root,
                                                 const DatasetOptions& options);

// The layouts that list_frames() tries, as text for messages.
[[nodiscard]] std::string describe_layouts();

// Each of these reads one layout and throws Error(kInput) if its files are there but inconsistent.
[[nodiscard]] Listing read_tum_lists(const std::filesystem::path& root,
                                     const DatasetOptions& options);
[[nodiscard]] Listing read_association_file(const std::filesystem::path& file,
                                            const DatasetOptions& options);
// By the time stamps that all names are, in ns, us or ms, or in seconds with a fraction; none where
// they are not.
[[nodiscard]] std::optional<Listing> pair_stamped_files(
    const std::vector<std::filesystem::path>& colour,
    const std::vector<std::filesystem::path>& depth, const DatasetOptions& options);
[[nodiscard]] Listing pair_numbered_files(const std::vector<std::filesystem::path>& colour,
                                          const std::vector<std::filesystem::path>& depth,
                                          const DatasetOptions& options);

}  // namespace edvo
