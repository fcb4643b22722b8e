message(FATAL_ERROR "find_package(Bullet) was called although the project has its own Bullet")
