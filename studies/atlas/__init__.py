"""The fretting atlas: published experiments simulated, compared and diagnosed, one folder an entry."""
