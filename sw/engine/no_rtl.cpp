// SPDX-License-Identifier: Apache-2.0
#include "base/error.hpp"
#include "engine/engine.hpp"

namespace ti {

std::unique_ptr<Engine> make_rtl_engine(const Image&, const Config&, const Tracer&,
                                        const RtlOptions&) {
  throw Error(
      "this program was built without the RTL: use ENGINE=model or ENGINE=embree, or start it by "
      "`make render`");
}

}  // namespace ti
