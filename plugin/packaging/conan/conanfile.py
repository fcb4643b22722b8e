# SPDX-License-Identifier: Zlib
"""Conan 2 recipe:  conan create plugin/packaging/conan --build=missing"""

from conan import ConanFile
from conan.tools.build import check_min_cppstd
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class LimberConan(ConanFile):
    name = "limber"
    version = "0.2.0"
    license = "Zlib"
    description = "Soft bodies for Bullet Physics worlds"
    topics = ("physics", "soft-body", "bullet")
    package_type = "library"
    settings = "os", "arch", "compiler", "build_type"
    options = {
        "shared": [True, False],
        "fPIC": [True, False],
        "double_precision": [True, False],
        "with_import": [True, False],
    }
    default_options = {"shared": False, "fPIC": True, "double_precision": False, "with_import": True}
    implements = ["auto_shared_fpic"]

    def export_sources(self):
        root = f"{self.recipe_folder}/../../.."
        for pattern in ("CMakeLists.txt", "LICENSE", "CHANGELOG.md", "plugin/*"):
            copy(self, pattern, root, self.export_sources_folder, excludes="plugin/packaging/*")

    def configure(self):
        self.options["bullet3"].double_precision = self.options.double_precision

    def requirements(self):
        self.requires("bullet3/[>=3.24]", transitive_headers=True, transitive_libs=True)
        self.requires("eigen/[>=3.3 <4]", transitive_headers=True)
        if self.options.with_import:
            self.requires("assimp/[>=5.2]")

    def validate(self):
        check_min_cppstd(self, 17)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        CMakeDeps(self).generate()
        toolchain = CMakeToolchain(self)
        for part in ("RENDER", "DEMO", "TESTS", "BENCH"):
            toolchain.cache_variables[f"LIMBER_{part}"] = False
        toolchain.cache_variables["LIMBER_IMPORT"] = bool(self.options.with_import)
        toolchain.cache_variables["LIMBER_DOUBLE"] = bool(self.options.double_precision)
        toolchain.cache_variables["LIMBER_USE_BULLET_CONFIG"] = True
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()
        copy(self, "LICENSE", self.source_folder, f"{self.package_folder}/licenses")

    def package_info(self):
        # Limber's own CMake package is used, which has its components
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs = ["lib/cmake/limber"]
        core = [] if self.options.shared else ["limber_analysis", "limber_core"]
        self.cpp_info.libs = (["limber_import"] if self.options.with_import else []) + ["limber"] + core
        if self.options.shared:
            self.cpp_info.defines = ["LIMBER_SHARED"]
        if self.settings.os in ("Linux", "FreeBSD"):
            self.cpp_info.system_libs = ["pthread"]
