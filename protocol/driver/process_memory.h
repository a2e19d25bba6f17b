#pragma once

namespace tandem {

/// Keeps freed memory in the process. Every step takes and frees the same large blocks (factors,
/// exchanged arrays); glibc gives them back to the kernel each time, and the page faults of taking
/// them again cost a quarter of a flexible step. First call of main().
void keep_freed_memory();

}  // namespace tandem
