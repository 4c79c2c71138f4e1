# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m headless ...`` in the source tree, ``python -m w2w.headless ...`` where W2W is installed."""

if __name__ == "__main__":
    from w2w.headless.start import main

    main()
