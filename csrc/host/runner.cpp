// Two threads, one for each view: the caller's takes the left one, a worker that waits between frames the right one.
#include <condition_variable>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>

#include "rvdnav/rvdnav.h"

namespace {

struct ViewJob {
  rvdnav_context* context;
  int32_t camera;
  const rvdnav_image* image;
  const rvdnav_window* windows;
  uint32_t window_count;
  rvdnav_view_result* result;

  rvdnav_status run() const {
    result->struct_size = sizeof(*result);
    return rvdnav_view(context, camera, image, windows, window_count, result);
  }
};

class Worker {
 public:
  Worker() : thread_([this] { loop(); }) {}

  ~Worker() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }

  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  void start(const ViewJob& job) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      job_ = job;
      busy_ = true;
    }
    changed_.notify_all();
  }

  rvdnav_status wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
    return status_;
  }

 private:
  void loop() {
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return busy_ || stop_; });
      if (stop_) return;
      const ViewJob job = job_;
      lock.unlock();
      const rvdnav_status status = job.run();
      lock.lock();
      status_ = status;
      busy_ = false;
      changed_.notify_all();
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  ViewJob job_ = {};
  rvdnav_status status_ = RVDNAV_OK;
  bool busy_ = false;
  bool stop_ = false;
  std::thread thread_;  // last: it uses all of the above
};

}  // namespace

struct rvdnav_runner {
  Worker worker;
  rvdnav_view_result views[RVDNAV_CAMERAS] = {};
};

rvdnav_status rvdnav_runner_create(rvdnav_runner** runner) {
  if (runner == nullptr) return RVDNAV_ERROR_NULL;
  *runner = nullptr;
  try {
    *runner = new rvdnav_runner;
  } catch (const std::bad_alloc&) {
    return RVDNAV_ERROR_MEMORY;
  } catch (const std::system_error&) {
    return RVDNAV_ERROR_THREAD;
  }
  return RVDNAV_OK;
}

void rvdnav_runner_destroy(rvdnav_runner* runner) { delete runner; }

rvdnav_status rvdnav_runner_process(rvdnav_runner* runner, rvdnav_context* context, const rvdnav_image* left,
                                    const rvdnav_image* right, const rvdnav_window* left_windows,
                                    uint32_t left_window_count, const rvdnav_window* right_windows,
                                    uint32_t right_window_count, rvdnav_frame_result* result) {
  if (runner == nullptr || result == nullptr || (left == nullptr && right == nullptr)) return RVDNAV_ERROR_NULL;
  const ViewJob left_job = {context, 0, left, left_windows, left_window_count, &runner->views[0]};
  const ViewJob right_job = {context, 1, right, right_windows, right_window_count, &runner->views[1]};
  if (right != nullptr) runner->worker.start(right_job);
  rvdnav_status status = left != nullptr ? left_job.run() : RVDNAV_OK;
  if (right != nullptr) {
    const rvdnav_status right_status = runner->worker.wait();
    if (status == RVDNAV_OK) status = right_status;
  }
  if (status != RVDNAV_OK) return status;
  const int32_t acquire = left_window_count == 0 && right_window_count == 0 ? 1 : 0;
  return rvdnav_join(context, left, right, left != nullptr ? &runner->views[0] : nullptr,
                     right != nullptr ? &runner->views[1] : nullptr, acquire, result);
}
