#pragma once
// Ends the handles that a program leaves open when its process ends.

namespace feltwire {

/// Has an object ended when the process ends, before any exit handler that was registered earlier:
/// the threads of the object use what those handlers free. The object is ended and not freed,
/// because another thread of the program may still use it. Objects are ended in reverse order.
/// Throws std::bad_alloc.
void end_at_exit(void* object, void (*end)(void* object) noexcept);

/// The program closes the object. It waits while the object is being ended.
void closes(const void* object) noexcept;

}  // namespace feltwire
