# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m w2w.headless ...`: the `w2w` command."""

if __name__ == "__main__":
    from w2w.headless.start import main

    main()
