"""What moves by itself at ticks: cloth, hair and ribbons on a dancer's body, and springs of characters."""
