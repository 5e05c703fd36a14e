// SPDX-License-Identifier: LGPL-2.1-or-later
// Memory that counts how often it is mapped and copied.
#pragma once

#include <gst/gst.h>

#include <atomic>

namespace csd_check {

/// Has its own allocator, which must outlive its memory. Usable from any thread.
class CountingMemory {
 public:
  CountingMemory() {
    allocator_->mem_map = map;
    allocator_->mem_unmap = [](GstMemory *) {};
    allocator_->mem_copy = copy;
  }
  ~CountingMemory() { gst_object_unref(allocator_); }
  CountingMemory(const CountingMemory &) = delete;
  CountingMemory &operator=(const CountingMemory &) = delete;

  GstMemory *allocate(gsize size) {
    auto *memory = g_new0(Memory, 1);
    gst_memory_init(&memory->base, static_cast<GstMemoryFlags>(0), allocator_, nullptr, size, 0, 0, size);
    memory->bytes = g_malloc0(size);
    memory->counts = this;
    return &memory->base;
  }
  int maps() const { return maps_; }
  int copies() const { return copies_; }

 private:
  struct Memory {
    GstMemory base;
    gpointer bytes;
    CountingMemory *counts;
  };
  struct Allocator {
    GstAllocator base;
  };
  struct AllocatorClass {
    GstAllocatorClass base;
  };

  static GType type() {
    static const GType made = g_type_register_static_simple(
        GST_TYPE_ALLOCATOR, "CsdCountingAllocator", sizeof(AllocatorClass),
        [](gpointer klass, gpointer) {
          static_cast<GstAllocatorClass *>(klass)->free = [](GstAllocator *, GstMemory *memory) {
            g_free(of(memory)->bytes);
            g_free(memory);
          };
        },
        sizeof(Allocator), nullptr, static_cast<GTypeFlags>(0));
    return made;
  }
  static Memory *of(GstMemory *memory) { return reinterpret_cast<Memory *>(memory); }
  static gpointer map(GstMemory *memory, gsize, GstMapFlags) {
    ++of(memory)->counts->maps_;
    return of(memory)->bytes;
  }
  static GstMemory *copy(GstMemory *memory, gssize, gssize) {
    ++of(memory)->counts->copies_;
    return of(memory)->counts->allocate(memory->size);
  }

  GstAllocator *allocator_ = static_cast<GstAllocator *>(gst_object_ref_sink(g_object_new(type(), nullptr)));
  std::atomic<int> maps_ = 0, copies_ = 0;
};

}  // namespace csd_check
