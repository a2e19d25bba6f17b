#pragma once

namespace tandem {

/// Opens /dev/null for each of standard input, output and error that is closed. Otherwise the next
/// file opened would take its place, and messages would be written into that file. To be called
/// first in main().
void open_standard_streams();

}  // namespace tandem
