#pragma once

#include <lamap_mrpt/learned_map/CLearnedMap.h>
#include <lamap_python/messages.h>
#include <lamap_python/released_gil.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <utility>

namespace lamap::python
{
/** A lock that many hold for reading or one for changing. Who waits to change goes before those who come
 * later to read, so that threads that ask all the time do not keep a change away. */
class ReadOrChangeLock
{
 public:
  void lock_shared()
  {
    const std::lock_guard<std::mutex> turn(turn_);
    mutex_.lock_shared();
  }
  void unlock_shared() { mutex_.unlock_shared(); }
  void lock()
  {
    const std::lock_guard<std::mutex> turn(turn_);  // kept until all who read have ended
    mutex_.lock();
  }
  void unlock() { mutex_.unlock(); }

 private:
  std::mutex turn_;
  std::shared_mutex mutex_;
};

/** A map as Python holds it. Any number of threads may read it at a time, or one change it; whoever waits or
 * works does so without the GIL.
 *
 * No lock is taken with the GIL held, and the GIL is not taken with a lock held: no two threads can wait for
 * each other. */
class MapObject
{
 public:
  /// @param map  never null, and nobody else's
  explicit MapObject(std::shared_ptr<CLearnedMap> map);
  virtual ~MapObject() = default;
  MapObject(const MapObject&) = delete;
  MapObject& operator=(const MapObject&) = delete;

  /// Only pybind11 calls this: for an object whose __init__ was not called, which it would hand over unmade.
  static void* operator new(size_t /*size*/)
  {
    throw pybind11::type_error("__init__ of this map was not called");
  }
  static void operator delete(void* memory) { ::operator delete(memory); }

  /// Calls work(const CLearnedMap&). @return what it returns, which must need no GIL
  template <typename Work>
  auto read(const Work& work) const
  {
    const ReleasedGil released;
    const std::shared_lock<ReadOrChangeLock> lock(mutex_);
    return work(std::as_const(*map_));
  }
  /// Calls work(CLearnedMap&), and then hands over to Python's logging what the map said.
  template <typename Work>
  auto change(const Work& work)
  {
    Messages messages;
    const auto result = [&]
    {
      const ReleasedGil released;
      const std::unique_lock<ReadOrChangeLock> lock(mutex_);
      const CollectedMessages collected(messages);
      return work(*map_);
    }();
    logMessages(messages);
    return result;
  }

  /// The map itself, for what asks for a shared pointer; only within read().
  [[nodiscard]] const std::shared_ptr<CLearnedMap>& pointer() const { return map_; }
  /// A map of its own, with the same content.
  [[nodiscard]] std::shared_ptr<CLearnedMap> copy() const;

  /// How lamap.build() made it, as JSON; empty if it did not.
  std::string report;

 private:
  std::shared_ptr<CLearnedMap> map_;
  mutable ReadOrChangeLock mutex_;
};

/// The class of Python for one class of maps.
template <typename Map>
class MapOf : public MapObject
{
 public:
  using MapObject::MapObject;

  [[nodiscard]] static std::unique_ptr<MapOf> of(std::shared_ptr<CLearnedMap> map)
  {
    return std::unique_ptr<MapOf>(::new MapOf(std::move(map)));
  }
};

/// A map as an object of the right class.
[[nodiscard]] std::unique_ptr<MapObject> objectOf(std::shared_ptr<CLearnedMap> map);

/// Adds the classes of maps to the module, and what their methods return.
void addMaps(pybind11::module_& module);

}  // namespace lamap::python
