// Gmsh meshes of versions 2 to 4.1, ASCII and binary.
#include <utility>

#include "fem_process/mesh/msh_content.h"
#include "fem_process/mesh/msh_stream.h"
#include "fem_process/mesh/raw_mesh.h"

namespace tandem::fem {
namespace {

class MshReader {
 public:
  explicit MshReader(const std::filesystem::path& file)
      : in_(file), content_(in_, raw_), old_(in_, content_, raw_), new_(in_, content_, raw_) {
    raw_.file = file;
    raw_.lines.begin(1, file);
  }

  RawMesh read() {
    in_.read_format();
    while (!in_.text().at_end()) section();
    if (!have_nodes_ || !have_elements_) {
      in_.fail(std::string("the file ends without a complete ") +
               (have_nodes_ ? "$Elements" : "$Nodes") +
               " section. It is truncated: write it again.");
    }
    return std::move(raw_);
  }

 private:
  void section() {
    const std::string header(in_.text().word("a section"));
    if (header.size() < 2 || header[0] != '$') {
      in_.fail("'" + header + "' where a $Section should begin. Write the mesh again.");
    }
    const std::string name = header.substr(1);
    const bool is_old = in_.version() == 20;
    if (name == "PhysicalNames") {
      content_.read_names();
    } else if (name == "Entities" && !is_old) {
      in_.begin_numbers();
      new_.entities();
    } else if (name == "Nodes") {
      if (!is_old) in_.begin_numbers();
      is_old ? old_.nodes() : new_.nodes();
      have_nodes_ = true;
    } else if (name == "Elements") {
      if (!is_old) in_.begin_numbers();
      is_old ? old_.elements() : new_.elements();
      have_elements_ = true;
    } else {
      raw_.notes.push_back("$" + name + " was passed over");
      in_.text().skip_to("$End" + name);
    }
    end_of(name);
  }

  void end_of(const std::string& name) {
    const std::string found(in_.text().word("$End" + name));
    if (found == "$End" + name) return;
    in_.fail("'" + (in_.binary() ? "other bytes" : found) + "' where $End" + name +
             " should be: the section's counts do not match its content. Write the mesh again.");
  }

  MshStream in_;
  RawMesh raw_;
  MshContent content_;
  MshVersion2 old_;
  MshVersion4 new_;
  bool have_nodes_ = false;
  bool have_elements_ = false;
};

}  // namespace

RawMesh read_msh(const std::filesystem::path& file) { return MshReader(file).read(); }

}  // namespace tandem::fem
