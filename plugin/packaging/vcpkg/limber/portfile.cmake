# An overlay port of the checkout that it is in:  vcpkg install limber --overlay-ports=CHECKOUT/plugin/packaging/vcpkg
# In a registry, vcpkg_from_git() or vcpkg_from_github() would set SOURCE_PATH.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)

vcpkg_check_features(OUT_FEATURE_OPTIONS FEATURE_OPTIONS
  FEATURES
    double-precision LIMBER_DOUBLE
    import           LIMBER_IMPORT)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS
    -DLIMBER_USE_BULLET_CONFIG=ON
    -DLIMBER_RENDER=OFF
    -DLIMBER_DEMO=OFF
    -DLIMBER_TESTS=OFF
    -DLIMBER_BENCH=OFF
    ${FEATURE_OPTIONS})
vcpkg_cmake_install()
vcpkg_copy_pdbs()
vcpkg_cmake_config_fixup(PACKAGE_NAME limber CONFIG_PATH lib/cmake/limber)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
