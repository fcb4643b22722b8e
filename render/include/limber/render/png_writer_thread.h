// SPDX-License-Identifier: Zlib
#pragma once

#include "limber/render/image.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace limber::render {

/// Writes PNG files, or does other work on images, on a thread of its own and in order. So the compression of
/// one frame overlaps with drawing the next one. Only one thread at a time may call it.
class PngWriterThread {
 public:
  static constexpr std::size_t kQueueLimit = 3;

  PngWriterThread();
  /// Writes the queued images, then joins the thread. Errors that submit() or finish() have not thrown are
  /// lost.
  ~PngWriterThread();
  PngWriterThread(const PngWriterThread&) = delete;
  PngWriterThread& operator=(const PngWriterThread&) = delete;

  /// Queues an image, waiting while kQueueLimit images are queued. Throws the first error of an
  /// earlier image (std::runtime_error); this image is then not queued.
  void submit(std::string path, Image image);
  /// Queues any other work on an image. Its error is the exception that `work` throws.
  void submit(Image image, std::function<void(const Image&)> work);
  /// Returns an image that was used before, so that its memory can be filled again; empty if there is none.
  Image takeSpare();
  /// Waits until everything is written. Throws the first error.
  void finish();

 private:
  struct Job {
    Image image;
    std::function<void(const Image&)> work;
  };

  void run();
  void throwPendingError(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> queue_;
  std::vector<Image> spares_;
  std::exception_ptr error_;
  bool busy_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace limber::render
