#include "protocol/driver/process_memory.h"

#include <cstdlib>

#if defined(__GLIBC__)  // known once any header of the C library is in
#include <malloc.h>
#endif

namespace tandem {

void keep_freed_memory() {
#if defined(__GLIBC__)
  constexpr int kLargestFromHeap = 32 << 20;  // the most that glibc accepts
  constexpr int kNeverTrim = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, kLargestFromHeap);
  mallopt(M_TRIM_THRESHOLD, kNeverTrim);
#endif
}

}  // namespace tandem
