"""Every figure, table and claim of Chen et al. (2018) on the nine-bar mechanism, computed anew; --help tells how."""

from nine_bar_study.command import main

if __name__ == "__main__":
    raise SystemExit(main())
