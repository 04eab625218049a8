"""The tables and figures of the paper, one module each, and the runs behind them."""
