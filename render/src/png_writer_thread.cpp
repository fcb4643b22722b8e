// SPDX-License-Identifier: Zlib
#include "limber/render/png_writer_thread.h"

#include <utility>

#include "limber/render/png_file.h"

namespace limber::render {

PngWriterThread::PngWriterThread() {
  thread_ = std::thread([this] { run(); });
}

PngWriterThread::~PngWriterThread() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void PngWriterThread::submit(std::string path, Image image) {
  submit(std::move(image), [path = std::move(path)](const Image& picture) { writePng(path, picture); });
}

void PngWriterThread::submit(Image image, std::function<void(const Image&)> work) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return queue_.size() < kQueueLimit || error_ != nullptr; });
  throwPendingError(lock);
  queue_.push_back({std::move(image), std::move(work)});
  lock.unlock();
  changed_.notify_all();
}

Image PngWriterThread::takeSpare() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (spares_.empty()) {
    return {};
  }
  Image spare = std::move(spares_.back());
  spares_.pop_back();
  return spare;
}

void PngWriterThread::finish() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return queue_.empty() && !busy_; });
  throwPendingError(lock);
}

void PngWriterThread::throwPendingError(std::unique_lock<std::mutex>& lock) {
  if (error_ == nullptr) {
    return;
  }
  const std::exception_ptr error = std::exchange(error_, nullptr);
  lock.unlock();
  std::rethrow_exception(error);
}

void PngWriterThread::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
    if (queue_.empty()) {
      return;
    }
    Job job = std::move(queue_.front());
    queue_.pop_front();
    busy_ = true;
    lock.unlock();
    changed_.notify_all();
    std::exception_ptr error;
    try {
      job.work(job.image);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    busy_ = false;
    if (error_ == nullptr) {
      error_ = error;
    }
    if (spares_.size() < kQueueLimit) {
      spares_.push_back(std::move(job.image));
    }
    changed_.notify_all();
  }
}

}  // namespace limber::render
